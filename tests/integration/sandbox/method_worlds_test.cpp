// The worlds of config/methods, each by other methods of physics: alone, then with bots on a bad
// network.
#include "server/app/world/world.h"
#include "server/config/expand/load_settings.h"
#include "server/config/expand/stability_report.h"
#include "server/config/expand/world_warnings.h"
#include "server/zone/simulation/representation.h"
#include "server/zone/zone_state.h"
#include "tests/harness/game_test.h"

#include <algorithm>
#include <filesystem>
#include <set>

namespace zoned::harness {
namespace {

const std::filesystem::path kMethodWorlds = ZONED_SOURCE_DIR "/config/methods";
constexpr int kMethodTicks = 1200;
constexpr int kThreadTicks = 240;  ///< played on three threads as well

/// Worlds of agents, named ai_*, have a test of their own (ai_methods_test.cpp).
std::vector<std::string> method_worlds() {
    std::set<std::string> names;
    for (const auto& entry : std::filesystem::directory_iterator(kMethodWorlds)) {
        const std::string name = entry.path().stem();
        if (entry.path().extension() == ".txtpb" && !name.starts_with("ai_")) {
            names.insert(name);
        }
    }
    return {names.begin(), names.end()};
}

config::Settings method_settings(const std::string& name) {
    const std::string file = (kMethodWorlds / (name + ".txtpb")).string();
    config::Settings settings;
    std::vector<config::ConfigError> errors;
    EXPECT_TRUE(config::load_settings(file, {}, settings, errors))
        << config::format_errors(file, errors);
    return settings;
}

/// A world without players; these worlds have one zone.
struct MethodRun {
    explicit MethodRun(const std::string& name, unsigned threads = 1)
        : settings(method_settings(name)),
          world(settings, threads) {}

    void tick() {
        world.tick({}, out);
        out.clear();
        const zone::StepReport& report = world.zones()[0]->report();
        broken += report.physics.quarantined + report.soft.quarantined;
        torn += report.soft.torn;
    }

    [[nodiscard]] const world::Entities& entities() const {
        return world.zones()[0]->state().entities;
    }

    [[nodiscard]] const world::EntityType& type_of(world::Row row) const {
        return settings.types[entities().type[row]];
    }

    config::Settings settings;
    app::World world;
    std::vector<mailbox::OutboxItem> out;
    std::uint32_t broken = 0;  ///< bodies that the physics had to stop
    std::uint32_t torn = 0;    ///< springs of soft bodies
};

/// The rigid bodies together.
struct BodySum {
    double energy_j = 0.0;   ///< of height, and of the motion of centres
    double weight_n = 0.0;   ///< of all
    double outside_m = 0.0;  ///< greatest distance beyond the world's rectangle or below the ground
};

BodySum sum_of(const MethodRun& run) {
    BodySum out;
    const config::ZoneRegion& region = run.settings.zones[0];
    const auto g = static_cast<double>(run.settings.physics.gravity.norm());
    const world::Entities& e = run.entities();
    for (world::Row row = 0; row < e.size(); ++row) {
        if (!e.body[row]) {
            continue;
        }
        const auto mass = static_cast<double>(run.type_of(row).mass);
        const Vec3d at = e.position[row].cast<double>();
        out.energy_j += mass * (g * at.y() + 0.5 * e.velocity[row].cast<double>().squaredNorm());
        out.weight_n += mass * g;
        out.outside_m = std::max({out.outside_m,
                                  std::abs(at.x()) - 0.5 * (region.max_x - region.min_x),
                                  std::abs(at.z()) - 0.5 * (region.max_z - region.min_z),
                                  -at.y()});
    }
    return out;
}

/// Things that stand where they are placed, on each other and on a slope.
bool is_block(const world::EntityType& type) {
    return type.name == "crate" || type.name == "brick" || type.name == "safe";
}

/// How far this block is from where one like it was placed, m.
double strayed(const MethodRun& run, world::Row row) {
    double least = INFINITY;
    for (const config::InitialEntity& placed : run.settings.initial) {
        if (placed.type == run.entities().type[row]) {
            const Vec3d at = run.entities().position[row].cast<double>();
            least = std::min(least, (at - placed.position).norm());
        }
    }
    return least;
}

class MethodWorld : public GameTest, public testing::WithParamInterface<std::string> {
  protected:
    MethodWorld() { server.config = (kMethodWorlds / (GetParam() + ".txtpb")).string(); }
};

TEST_P(MethodWorld, IsCheckedWithoutAWarning) {
    const config::Settings settings = method_settings(GetParam());
    EXPECT_THAT(config::stability_warnings_of(settings), testing::IsEmpty());
    EXPECT_THAT(config::world_warnings_of(settings), testing::IsEmpty());
}

/// Nothing drives these things, so that they never have more energy than they were placed with. An
/// overlap that a method undoes gives back its depth times the weight: a hundredth of a metre at
/// most. A block that falls goes farther than half of its edge; one that is set down on the slope
/// goes less far.
TEST_P(MethodWorld, StandsAndGainsNoEnergyOnAnyNumberOfThreads) {
    MethodRun one(GetParam());
    MethodRun three(GetParam(), 3);
    const BodySum placed = sum_of(one);
    for (int tick = 0; tick < kMethodTicks; ++tick) {
        one.tick();
        if (tick < kThreadTicks) {
            three.tick();
        }
        if (tick + 1 == kThreadTicks) {
            ASSERT_EQ(one.world.state_hash(), three.world.state_hash());
        }
        const BodySum now = sum_of(one);
        ASSERT_LE(now.energy_j, placed.energy_j + 0.01 * placed.weight_n) << "in tick " << tick;
        ASSERT_LE(now.outside_m, 0.0) << "in tick " << tick;
        ASSERT_EQ(one.broken, 0U) << "in tick " << tick;
    }
    for (world::Row row = 0; row < one.entities().size(); ++row) {
        if (is_block(one.type_of(row))) {
            EXPECT_LT(strayed(one, row), 0.4) << one.entities().position[row].transpose();
        }
    }
}

TEST_P(MethodWorld, IsSeenAsPromisedOnABadNetwork) {
    server.network.loss = 0.05;
    server.network.delay_s = 0.06;
    server.network.jitter_s = 0.02;
    std::uint64_t beyond_limits = 0;
    std::uint64_t broken = 0;
    const measure::RunReport report = run([&](VirtualServer& now, double) {
        for (const auto& zone : now.world().zones()) {
            beyond_limits += zone->report().replication.limit_exceeded;
            broken += zone->report().physics.quarantined + zone->report().soft.quarantined;
        }
    });
    EXPECT_TRUE(report.consistent) << reasons(report);
    EXPECT_GT(report.audit.samples, 200U);
    EXPECT_EQ(beyond_limits, 0U) << "the config declares too low limits";
    EXPECT_EQ(broken, 0U);
}

INSTANTIATE_TEST_SUITE_P(Shipped,
                         MethodWorld,
                         testing::ValuesIn(method_worlds()),
                         [](const auto& world) { return world.param; });

/// Two weights fall through a net, whose sides hold, and through a line. One dents a lump of clay
/// that another lump like it was not hit by.
TEST(Fabric, TearsAndKeepsDentsWhereAWeightFallsOnIt) {
    MethodRun run("fabric");
    for (int tick = 0; tick < 300; ++tick) {
        run.tick();
    }
    EXPECT_GT(run.torn, 0U);
    const world::Entities& e = run.entities();
    std::vector<float> clay_m;
    for (world::Row row = 0; row < e.size(); ++row) {
        const std::string& name = run.type_of(row).name;
        const float height = e.position[row].y();
        if (name == "shot") {
            EXPECT_LT(height, 0.55F) << "it lies on the ground";
        } else if (name == "net") {
            EXPECT_GT(height, 1.5F) << "it hangs";
        } else if (name == "line") {
            EXPECT_LT(height, 1.0F) << "its halves hang";
        } else if (name == "clay") {
            clay_m.push_back(height);
        }
    }
    ASSERT_EQ(clay_m.size(), 2U);
    EXPECT_LT(clay_m[0], clay_m[1] - 0.02F);
}

/// As no player is near, all are points as soon as they move freely. Without friction each slides
/// down, up the other side, and back.
TEST(Distances, MakePointsOfWhatNobodySeesWhichSlideOn) {
    MethodRun run("distances");
    const world::Entities& e = run.entities();
    ASSERT_GT(e.size(), 0U);
    for (int tick = 0; tick < 1200; ++tick) {
        run.tick();
    }
    for (world::Row row = 0; row < e.size(); ++row) {
        const float before = static_cast<float>(run.settings.initial[row].position.x());
        EXPECT_EQ(static_cast<zone::Representation>(e.representation[row]),
                  zone::Representation::kParticle)
            << run.type_of(row).name;
        EXPECT_NEAR(e.position[row].x(), -before, 20.0F) << run.type_of(row).name;
    }
}

}  // namespace
}  // namespace zoned::harness
