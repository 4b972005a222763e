// Flocks of a particle system: the path, the weights, the home, and the same bits on all sides.
#include "server/compute/device.h"
#include "server/compute/worker_pool.h"
#include "server/physics/particles/flock_path.h"
#include "server/physics/particles/particle_systems.h"
#include "tests/unit/allocation_count.h"

#include <gtest/gtest.h>

#include <cmath>

namespace zoned::physics {
namespace {

constexpr float kFlockStep_s = 1.0F / 60.0F;

/// A home of 100 x 20 x 100 m.
FlockDef home_of_100() {
    FlockDef def;
    def.low = Vec3d(0.0, 0.0, 0.0);
    def.high = Vec3d(100.0, 20.0, 100.0);
    return def;
}

motion::Emitter roost(std::uint64_t count) {
    motion::Emitter e;
    e.seed = 3;
    e.rate_hz = 1e9;
    e.most = count;
    e.position = Vec3(50.0F, 10.0F, 50.0F);
    e.spread = 8.0F;
    e.cone_cosine = -1.0F;
    e.speed_min = 4.0F;
    e.speed_max = 8.0F;
    e.lifetime_min_s = e.lifetime_max_s = 3600.0F;
    return e;
}

/// One flock that steps alone.
class FlockOf {
  public:
    FlockOf(const FlockDef& flock, const motion::Emitter& emitter) {
        ParticleSystemDef def;
        def.name = "birds";
        def.flock = flock;
        id_ = *systems_.add(std::move(def));
        EXPECT_TRUE(systems_.add_emitter(id_, emitter).ok());
    }

    ParticleReport step(compute::Team& team) { return systems_.step(now_++, kFlockStep_s, team); }

    void run(int steps) {
        compute::Team alone;
        for (int i = 0; i < steps; ++i) {
            step(alone);
        }
    }

    ParticleSystems& systems() { return systems_; }

    [[nodiscard]] const ParticleSystem& birds() const { return *systems_.find(id_); }

    [[nodiscard]] Vec3d mean() const {
        Vec3d sum = Vec3d::Zero();
        for (std::size_t i = 0; i < birds().size(); ++i) {
            sum += birds().position(i).cast<double>();
        }
        return sum / static_cast<double>(birds().size());
    }

    /// The root of the mean square distance to the mean, m.
    [[nodiscard]] double extent() const {
        const Vec3d middle = mean();
        double sum = 0.0;
        for (std::size_t i = 0; i < birds().size(); ++i) {
            sum += (birds().position(i).cast<double>() - middle).squaredNorm();
        }
        return std::sqrt(sum / static_cast<double>(birds().size()));
    }

    /// Length of the mean direction: 1 where all fly the same way.
    [[nodiscard]] double order() const {
        Vec3d sum = Vec3d::Zero();
        for (std::size_t i = 0; i < birds().size(); ++i) {
            sum += birds().velocity(i).cast<double>().normalized();
        }
        return sum.norm() / static_cast<double>(birds().size());
    }

  private:
    ParticleSystems systems_;
    ParticleSystemId id_;
    Tick now_ = 0;
};

Vec2 direction_in(const std::vector<float>& directions,
                  const kernels::FlockRules& rules,
                  int column,
                  int row) {
    const auto at = 2 * static_cast<std::size_t>(row * rules.field_columns + column);
    return {directions[at], directions[at + 1]};
}

TEST(FlockPath, LeadsAlongAPathAndBackToIt) {
    // Along x at z = 5.5, from 0.5 to 20.5, cells of 1 m, so that middles of cells lie on it.
    FlockDef def;
    def.high = Vec3d(30.0, 1.0, 12.0);
    def.path = {{0.5, 5.5}, {20.5, 5.5}};
    def.path_width = 4.0F;
    kernels::FlockRules rules{};
    const std::vector<float> f = directions_along(def, rules);
    ASSERT_EQ(rules.field_columns, 30);
    ASSERT_EQ(f.size(), 2U * 30 * 12);
    EXPECT_TRUE(direction_in(f, rules, 10, 5).isApprox(Vec2(1.0F, 0.0F), 1e-6F)) << "on it";
    // 4 m beside it: as much towards it as along it.
    const Vec2 slanted(std::sqrt(0.5F), std::sqrt(0.5F));
    EXPECT_TRUE(direction_in(f, rules, 10, 1).isApprox(slanted, 1e-6F));
    EXPECT_TRUE(direction_in(f, rules, 10, 9).isApprox(Vec2(slanted.x(), -slanted.y()), 1e-6F));
    EXPECT_TRUE(direction_in(f, rules, 25, 5).isApprox(Vec2(-1.0F, 0.0F), 1e-6F)) << "beyond it";
}

TEST(FlockPath, ThatIsClosedLeadsBackToItsBeginning) {
    FlockDef def;
    def.high = Vec3d(30.0, 1.0, 30.0);
    def.path = {{5.5, 5.5}, {25.5, 5.5}, {25.5, 25.5}, {5.5, 25.5}};
    def.path_width = 4.0F;
    def.closed = true;
    kernels::FlockRules rules{};
    const std::vector<float> f = directions_along(def, rules);
    EXPECT_TRUE(direction_in(f, rules, 5, 15).isApprox(Vec2(0.0F, -1.0F), 1e-6F));
}

/// A flock of 200 that starts beside a path follows it to its end.
TEST(FlockOfParticles, FollowsAPathToItsEnd) {
    FlockDef def = home_of_100();
    def.path = {{10.0, 10.0}, {90.0, 10.0}, {90.0, 90.0}};
    def.path_width = 6.0F;
    def.follow = 2.0F;
    def.least_speed = 1.0F;
    def.most_speed = 6.0F;
    motion::Emitter start = roost(200);
    start.position = Vec3(16.0F, 10.0F, 27.0F);
    FlockOf flock(def, start);
    double at_bend = 1e9;
    // 160 m of path at up to 6 m/s: 27 s at best.
    for (int second = 0; second < 45; ++second) {
        flock.run(60);
        at_bend = std::min(at_bend, std::hypot(flock.mean().x() - 90.0, flock.mean().z() - 10.0));
    }
    EXPECT_LT(std::hypot(flock.mean().x() - 90.0, flock.mean().z() - 90.0), 15.0);
    EXPECT_LT(at_bend, 15.0) << "it cuts across";
}

TEST(FlockOfParticles, EachWeightDoesWhatItsNameSays) {
    FlockDef none = home_of_100();
    none.separation = none.alignment = none.cohesion = 0.0F;
    const auto after = [](const FlockDef& def) {
        auto flock = std::make_unique<FlockOf>(def, roost(200));
        flock->run(180);
        return flock;
    };
    // Nobody steers: each goes its way at 4 to 8 m/s for 3 s, 8 m apart at the most before.
    const auto apart = after(none);
    EXPECT_GT(apart->extent(), 12.0);
    EXPECT_LT(apart->order(), 0.3);
    FlockDef together = none;
    together.cohesion = 2.0F;
    together.radius = 40.0F;
    EXPECT_LT(after(together)->extent(), apart->extent() / 1.5);
    FlockDef aligned = none;
    aligned.alignment = 3.0F;
    aligned.radius = 40.0F;
    EXPECT_GT(after(aligned)->order(), 0.9);
    // Pushed together by cohesion, separation keeps them apart.
    FlockDef wide = together;
    wide.separation = 40.0F;
    wide.separation_radius = 10.0F;
    EXPECT_GT(after(wide)->extent(), 1.2 * after(together)->extent());
}

/// How far an animal comes out of its home at the most: from most_speed it is turned back by at
/// least what turn_back is more than the flock's own acceleration, along each axis.
double farthest_out(const FlockDef& def) {
    const double back = static_cast<double>(def.turn_back - def.most_acceleration);
    const double speed = static_cast<double>(def.most_speed);
    return speed * speed / (2.0 * back) + speed * static_cast<double>(kFlockStep_s);
}

TEST(FlockOfParticles, StaysAboutItsHomeAndWithinItsSpeeds) {
    FlockDef def = home_of_100();
    def.most_acceleration = 5.0F;
    FlockOf flock(def, roost(500));
    for (int second = 0; second < 60; ++second) {
        flock.run(60);
        ASSERT_EQ(flock.birds().size(), 500U);
        for (std::size_t i = 0; i < flock.birds().size(); ++i) {
            const Vec3d at = flock.birds().position(i).cast<double>();
            const double out = std::max((def.low - at).maxCoeff(), (at - def.high).maxCoeff());
            EXPECT_LE(out, farthest_out(def)) << at.transpose();
            const float speed = flock.birds().velocity(i).norm();
            EXPECT_LE(speed, def.most_speed * 1.0001F);
            // One that has just come in may have been slow outside; two steps do not cross a metre.
            EXPECT_TRUE(out > -1.0 || speed >= def.least_speed * 0.9999F) << speed;
        }
    }
}

TEST(FlockOfParticles, OneThatFliesStraightOutComesBack) {
    FlockDef def = home_of_100();
    def.most_acceleration = 0.1F;  // it has nobody to steer by
    motion::Emitter one = roost(1);
    one.spread = 0.0F;
    one.cone_cosine = 1.0F;
    one.direction = Vec3::UnitX();
    FlockOf flock(def, one);
    double farthest = 0.0;
    double nearest = 1e9;
    for (int step = 0; step < 60 * 60; ++step) {
        flock.run(1);
        farthest = std::max(farthest, flock.mean().x());
        nearest = step > 60 * 30 ? std::min(nearest, flock.mean().x()) : nearest;
    }
    EXPECT_GT(farthest, def.high.x());
    EXPECT_LT(farthest, def.high.x() + farthest_out(def));
    EXPECT_LT(nearest, 50.0);
}

/// Hash after two seconds.
std::uint64_t hash_with(unsigned threads, compute::Device* device) {
    compute::WorkerPool pool(threads);
    compute::Team team;
    team.join_pool(pool);
    FlockDef def = home_of_100();
    def.path = {{10.0, 10.0}, {90.0, 10.0}};
    FlockOf flock(def, roost(3000));
    // A CPU said to be slow sends all to the device, and only flocks are asked about.
    const compute::Crossover always({1e9, 1.0, 0.0}, {});
    flock.systems().use_device(device, {}, device != nullptr ? always : compute::Crossover());
    unsigned on_device = 0;
    for (int i = 0; i < 120; ++i) {
        on_device += flock.step(team).on_device;
    }
    EXPECT_EQ(on_device, device != nullptr ? 119U : 0U);
    core::StateHash hash;
    flock.systems().hash(hash);
    return hash.value();
}

TEST(FlockOfParticles, HasTheSameBitsForAnyNumberOfThreadsAndOnADevice) {
    const std::uint64_t one = hash_with(1, nullptr);
    EXPECT_EQ(hash_with(2, nullptr), one);
    EXPECT_EQ(hash_with(4, nullptr), one);
    auto device = compute::Device::open({});
    ASSERT_TRUE(device.ok()) << device.error();
    EXPECT_EQ(hash_with(2, device->get()), one);
}

TEST(FlockOfParticles, AllocatesNothingOnceAllAreThere) {
    FlockOf flock(home_of_100(), roost(2000));
    flock.run(300);
    const std::uint64_t before = allocation_count();
    flock.run(60);
    EXPECT_EQ(allocation_count(), before);
}

TEST(FlockOfParticles, IsRefusedWhereItMeansNothing) {
    const auto why = [](auto change) {
        FlockDef def = home_of_100();
        change(def);
        return unfit(def);
    };
    EXPECT_EQ(why([](FlockDef&) {}), "");
    EXPECT_NE(why([](FlockDef& d) { d.radius = 0.0F; }), "");
    EXPECT_NE(why([](FlockDef& d) { d.cohesion = -1.0F; }), "");
    EXPECT_NE(why([](FlockDef& d) { d.separation_radius = 6.0F; }), "");
    EXPECT_NE(why([](FlockDef& d) { d.least_speed = 13.0F; }), "");
    EXPECT_NE(why([](FlockDef& d) { d.high.y() = d.low.y(); }), "");
    EXPECT_NE(why([](FlockDef& d) { d.path = {{0.0, 0.0}}; }), "");
    EXPECT_NE(why([](FlockDef& d) {
                  d.path = {{0.0, 0.0}, {1.0, 0.0}};
                  d.follow = 0.0F;
              }),
              "");
    ParticleSystems systems;
    ParticleSystemDef def;
    def.name = "birds";
    def.flock = home_of_100();
    def.flock->turn_back = NAN;
    const auto added = systems.add(std::move(def));
    ASSERT_FALSE(added.ok());
    EXPECT_EQ(added.error().rfind("birds: flock.", 0), 0U) << added.error();
}

}  // namespace
}  // namespace zoned::physics
