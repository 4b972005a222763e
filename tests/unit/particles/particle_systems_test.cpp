#include "server/physics/particles/particle_systems.h"

#include "server/compute/device.h"
#include "server/compute/worker_pool.h"
#include "tests/unit/allocation_count.h"

#include <gtest/gtest.h>

#include <cmath>

namespace zoned::physics {
namespace {

constexpr float kH = 1.0F / 60.0F;

motion::Emitter fountain(std::uint64_t seed) {
    motion::Emitter e;
    e.seed = seed;
    e.rate_hz = 9000.0;
    e.position = Vec3(0.0F, 2.0F, 0.0F);
    e.spread = 0.2F;
    e.cone_cosine = 0.8F;
    e.speed_min = 4.0F;
    e.speed_max = 9.0F;
    e.lifetime_min_s = 0.3F;
    e.lifetime_max_s = 1.5F;
    return e;
}

ParticleSystemDef full_def() {
    ParticleSystemDef def;
    def.name = "spray";
    def.linear_drag = 0.3F;
    def.quadratic_drag = 0.02F;
    def.wind.uniform = Vec3(2.0F, 0.0F, -1.0F);
    def.wind.gust_speed = 3.0F;
    def.wind.seed = 4;
    def.radius = 0.01F;
    def.walls.push_back({});
    def.balls.push_back({Vec3(1.0F, 1.0F, 0.0F), 0.8F});
    const std::vector<float> heights(17 * 17, 0.2F);
    FieldOptions options;
    options.columns = 17;
    options.rows = 17;
    def.field = *build_heightfield(heights, options);
    return def;
}

/// Hash after some seconds with so many threads, or on a device.
std::uint64_t run(unsigned threads, compute::Device* device, std::size_t* particles = nullptr) {
    compute::WorkerPool pool(threads);
    compute::Team team;
    team.join_pool(pool);
    ParticleSystems systems;
    // A CPU said to be slow sends all to the device.
    systems.use_device(
        device, device != nullptr ? compute::Crossover({1e9, 1.0, 0.0}, {}) : compute::Crossover());
    const ParticleSystemId id = *systems.add(full_def());
    EXPECT_TRUE(systems.add_emitter(id, fountain(1)).ok());
    EXPECT_TRUE(systems.add_emitter(id, fountain(2)).ok());
    unsigned on_device = 0;
    for (Tick t = 0; t < 150; ++t) {
        on_device += systems.step(t, kH, team).on_device;
    }
    // The side is chosen before the births: the first step finds nothing to send.
    EXPECT_EQ(on_device, device != nullptr ? 149U : 0U);
    core::StateHash hash;
    systems.hash(hash);
    if (particles != nullptr) {
        *particles = systems.find(id)->size();
    }
    return hash.value();
}

TEST(ParticleSystems, HaveTheSameBitsForAnyNumberOfThreadsAndOnADevice) {
    std::size_t particles = 0;
    const std::uint64_t one = run(1, nullptr, &particles);
    EXPECT_GT(particles, 8192U) << "one block would be no test of threads";
    EXPECT_EQ(run(2, nullptr), one);
    EXPECT_EQ(run(4, nullptr), one);
    const auto device = compute::Device::open({});
    ASSERT_TRUE(device.ok()) << device.error();
    EXPECT_EQ(run(1, device->get()), one);
}

/// Births less deaths are there, and their number settles at rate times mean life: 9000/s x 0.9 s,
/// give or take the fraction of a step by which lives are rounded up.
TEST(ParticleSystems, HoldRateTimesLifeManyParticles) {
    ParticleSystems systems;
    compute::Team alone;
    ParticleSystemDef def;
    def.gravity = Vec3::Zero();
    const ParticleSystemId id = *systems.add(def);
    ASSERT_TRUE(systems.add_emitter(id, fountain(3)).ok());
    std::size_t born = 0;
    std::size_t died = 0;
    for (Tick t = 0; t < 240; ++t) {
        const ParticleReport report = systems.step(t, kH, alone);
        born += report.counts.born;
        died += report.counts.died;
        ASSERT_EQ(report.particles, born - died);
    }
    EXPECT_NEAR(static_cast<double>(born), 9000.0 * 4.0, 1.0);  // a float's 1/60 is not exact
    const double expected = 9000.0 * 0.9;
    // 5 standard deviations of the sum of uniform lives, and one step of births.
    EXPECT_NEAR(static_cast<double>(systems.find(id)->size()), expected, 5.0 * 52.0 + 150.0);
}

/// Without forces a particle flies straight, whatever part of a step it was born in.
TEST(ParticleSystems, AreBornWithinTheStep) {
    ParticleSystems systems;
    compute::Team alone;
    ParticleSystemDef def;
    def.gravity = Vec3::Zero();
    const ParticleSystemId id = *systems.add(def);
    motion::Emitter ray;
    ray.rate_hz = 250.0;
    ray.direction = Vec3::UnitX();
    ray.speed_min = ray.speed_max = 10.0F;
    ray.lifetime_min_s = ray.lifetime_max_s = 100.0F;
    ASSERT_TRUE(systems.add_emitter(id, ray).ok());
    for (Tick t = 0; t < 60; ++t) {
        systems.step(t, kH, alone);
    }
    const ParticleSystem& system = *systems.find(id);
    ASSERT_GE(system.size(), 250U);  // 60 of a float's 1/60 may be a little more than a second
    for (std::size_t i = 0; i < 250; ++i) {
        const double age = 1.0 - static_cast<double>(i) / 250.0;
        // 60 additions of some metres, half an ulp each.
        EXPECT_NEAR(static_cast<double>(system.position(i).x()), 10.0 * age, 60 * 5e-7);
    }
}

TEST(ParticleSystems, ComeToTheSpeedAtWhichDragCarriesTheWeight) {
    ParticleSystems systems;
    compute::Team alone;
    ParticleSystemDef def;
    def.quadratic_drag = 0.5F;
    const ParticleSystemId id = *systems.add(def);
    motion::Emitter drop;
    drop.most = 1;
    drop.lifetime_min_s = drop.lifetime_max_s = 100.0F;
    ASSERT_TRUE(systems.add_emitter(id, drop).ok());
    for (Tick t = 0; t < 600; ++t) {
        systems.step(t, kH, alone);
    }
    // The implicit step's fixed point is exact: v = (v + h g) / (1 + h k |v|) gives k v^2 = g, but for rounding.
    EXPECT_NEAR(systems.find(id)->velocity(0).y(), -std::sqrt(9.81F / 0.5F), 1e-4F);
}

TEST(ParticleSystems, StayOutOfWhatTheyHit) {
    ParticleSystems systems;
    compute::Team alone;
    const ParticleSystemDef def = full_def();
    const ParticleSystemId id = *systems.add(def);
    ASSERT_TRUE(systems.add_emitter(id, fountain(5)).ok());
    float worst = INFINITY;
    for (Tick t = 0; t < 120; ++t) {
        systems.step(t, kH, alone);
        const ParticleSystem& system = *systems.find(id);
        for (std::size_t i = 0; i < system.size(); ++i) {
            const Vec3 p = system.position(i);
            worst = std::min(worst, p.y());
            if (std::abs(p.x()) < 8.0F && std::abs(p.z()) < 8.0F) {
                ASSERT_GE(p.y(), 0.2F + def.radius - 1e-5F) << "under the field";
            }
            // Pushed out of the field last, it may be in the ball only where both meet.
            if (p.y() > 0.25F) {
                ASSERT_GE((p - def.balls[0].centre).norm(), 0.8F) << "in the ball";
            }
        }
    }
    EXPECT_GE(worst, def.radius - 1e-5F);
}

TEST(ParticleSystems, DoNotPassThroughABallHoweverFast) {
    ParticleSystems systems;
    compute::Team alone;
    ParticleSystemDef def;
    def.gravity = Vec3::Zero();
    def.balls.push_back({Vec3(5.0F, 0.0F, 0.0F), 0.1F});
    const ParticleSystemId id = *systems.add(def);
    motion::Emitter shot;
    shot.most = 1;
    shot.direction = Vec3::UnitX();
    shot.speed_min = shot.speed_max = 400.0F;  // 6.7 m a step
    ASSERT_TRUE(systems.add_emitter(id, shot).ok());
    for (Tick t = 0; t < 10; ++t) {
        systems.step(t, kH, alone);
    }
    EXPECT_LT(systems.find(id)->position(0).x(), 5.0F);
    EXPECT_NEAR(systems.find(id)->velocity(0).x(), -400.0F * def.restitution, 1e-3F);
}

TEST(ParticleSystems, AllocateNothingOnceWarm) {
    ParticleSystems systems;
    compute::Team alone;
    const ParticleSystemId id = *systems.add(full_def());
    ASSERT_TRUE(systems.add_emitter(id, fountain(6)).ok());
    Tick t = 0;
    for (; t < 300; ++t) {
        systems.step(t, kH, alone);
    }
    const auto before = allocation_count();
    for (; t < 360; ++t) {
        systems.step(t, kH, alone);
    }
    EXPECT_EQ(allocation_count(), before);
}

TEST(ParticleSystems, RefuseBadInputWithThePlaceAndTheReason) {
    ParticleSystems systems;
    EXPECT_TRUE(systems.empty());
    ParticleSystemDef def;
    def.name = "smoke";
    def.restitution = 2.0F;
    EXPECT_EQ(systems.add(def).error(), "smoke: restitution: must be 0..1");
    def.restitution = 0.0F;
    def.linear_drag = NAN;
    EXPECT_FALSE(systems.add(def).ok());
    def.linear_drag = 0.0F;
    def.wind.gusts.resize(7);
    EXPECT_EQ(systems.add(def).error(), "smoke: wind.gusts: 7 velocities instead of 512");
    EXPECT_TRUE(systems.empty());
    const ParticleSystemId id = *systems.add(full_def());
    motion::Emitter wrong;
    wrong.lifetime_min_s = 0.0F;
    EXPECT_NE(systems.add_emitter(id, wrong).error().find("spray: emitter: lifetime"),
              std::string::npos);
    EXPECT_FALSE(systems.add_emitter(ParticleSystemId(7), motion::Emitter()).ok());
    EXPECT_TRUE(systems.remove(id));
    EXPECT_FALSE(systems.remove(id));
    EXPECT_TRUE(systems.empty());
}

}  // namespace
}  // namespace zoned::physics
