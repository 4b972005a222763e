// The world `hills`: walking and falling entities meet surfaces from files, on both sides of the
// wire.
#include "server/app/world/world.h"
#include "server/config/expand/load_settings.h"
#include "server/zone/zone_state.h"
#include "tests/harness/game_test.h"

#include <cmath>
#include <functional>
#include <map>

namespace zoned::harness {
namespace {

constexpr const char* kHills = ZONED_SOURCE_DIR "/config/hills.txtpb";

class Hills : public GameTest {
  protected:
    Hills() {
        server.config = kHills;
        bots.bots = 12;
        bots.seconds = 10.0;
    }
};

/// Observations of the characters.
struct Walkers {
    int on_hills = 0;      ///< grounded with more than 2 m of hill underfoot
    float deepest = 0.0F;  ///< of a capsule's bottom below the surface, m
    float highest = 0.0F;  ///< of a grounded one's bottom above it, m

    void look(app::World& world) {
        for (const auto& zone : world.zones()) {
            const zone::ZoneState& state = zone->state();
            const world::Entities& e = state.entities;
            for (world::Row row = 0; row < e.size(); ++row) {
                const world::EntityType& type = (*state.settings.types)[e.type[row]];
                if (type.kind != world::EntityKind::kCharacter) {
                    continue;
                }
                const Vec3& p = e.position[row];
                const float floor = state.settings.statics->floor_at(p.x(), p.z());
                const float bottom = p.y() - type.radius - type.half_segment;
                deepest = std::max(deepest, floor - bottom);
                if (e.has(row, world::kGrounded) && !e.has(row, world::kGhost)) {
                    highest = std::max(highest, bottom - floor);
                    on_hills += floor > 2.0F ? 1 : 0;
                }
            }
        }
    }
};

TEST_F(Hills, CarryBotsWithAConsistentVerdictAndNoCorrections) {
    Walkers walkers;
    const measure::RunReport report =
        run([&](VirtualServer& now, double) { walkers.look(now.world()); });
    EXPECT_TRUE(report.consistent) << reasons(report);
    EXPECT_GT(report.audit.samples, 300u);
    EXPECT_GT(walkers.on_hills, 10000);
    EXPECT_LE(walkers.deepest, 0.001F);
    // A capsule touches a slope of t degrees r (1 / cos t - 1) above the ground under its axis. On
    // walkable slopes (50 degrees) and at rims that is at most 0.23 m, and a step up.
    EXPECT_LT(walkers.highest, 0.55F);
    // Clients know the surfaces: their own avatars are predicted as on flat ground.
    EXPECT_LT(report.own_correction_m.percentile(0.99), 0.001);
}

TEST_F(Hills, AreConsistentOnABadNetworkAcrossTheBorder) {
    server.network.loss = 0.05;
    server.network.delay_s = 0.06;
    server.network.jitter_s = 0.02;
    const measure::RunReport report = run();
    EXPECT_TRUE(report.consistent) << reasons(report);
    EXPECT_GT(world->world().client_handoffs(), 0u);
}

TEST_F(Hills, CostClientsThatAreNotToldCorrectionsButNoConsistency) {
    server.network.delay_s = 0.03;
    const double told = run().own_correction_m.percentile(0.99);
    server.sets = {"statics.surface[0].replicated=false",
                   "statics.surface[1].replicated=false",
                   "statics.surface[2].replicated=false"};
    const measure::RunReport report = run();
    EXPECT_TRUE(report.consistent) << reasons(report);
    ASSERT_GT(report.own_correction_m.count(), 100u);
    const double untold = report.own_correction_m.percentile(0.99);
    RecordProperty("told_mm_p99", std::to_string(1000.0 * told));
    RecordProperty("untold_mm_p99", std::to_string(1000.0 * untold));
    EXPECT_LT(told, 0.001);
    // They fall through unknown ground until an update comes. It comes within 0.2 s between states
    // + 0.06 s there and back + the lead of inputs.
    EXPECT_GT(untold, 0.05);
    EXPECT_LT(untold, 3.0);
}

/// Ticks a world without clients.
void tick(app::World& world, int ticks) {
    std::vector<mailbox::OutboxItem> out;
    for (int t = 0; t < ticks; ++t) {
        out.clear();
        world.tick({}, out);
    }
}

/// Calls visit(state, row, type) for each prop that a zone owns.
void for_props(app::World& world,
               const std::function<void(const zone::ZoneState&, world::Row, std::string)>& visit) {
    for (const auto& zone : world.zones()) {
        const zone::ZoneState& state = zone->state();
        for (world::Row row = 0; row < state.entities.size(); ++row) {
            const world::EntityType& type = (*state.settings.types)[state.entities.type[row]];
            if (type.kind == world::EntityKind::kProp && !state.entities.has(row, world::kGhost)) {
                visit(state, row, type.name);
            }
        }
    }
}

TEST_F(Hills, HoldPropsThatFall) {
    config::Settings settings;
    std::vector<config::ConfigError> errors;
    // Goats that stand still push no crates.
    ASSERT_TRUE(
        config::load_settings(kHills, {"brain[graze].state[walk].action=IDLE"}, settings, errors))
        << config::format_errors(kHills, errors);
    app::World hills(settings, 1);
    tick(hills, 50 * 30);
    std::map<std::uint32_t, Vec3> before;
    for_props(hills, [&](const zone::ZoneState& state, world::Row row, const std::string&) {
        before[state.entities.id[row].value] = state.entities.position[row];
    });
    tick(hills, 10 * 30);
    int balls = 0;
    int crates_on_hills = 0;
    int awake = 0;
    for_props(hills, [&](const zone::ZoneState& state, world::Row row, const std::string& type) {
        const world::Entities& e = state.entities;
        const Vec3& p = e.position[row];
        const float floor = state.settings.statics->floor_at(p.x(), p.z());
        // Half a crate (or a ball's radius) above the ground, less the give of contacts, and more
        // by the lift of a slope of 25 degrees.
        EXPECT_GT(p.y(), floor + 0.4F - 0.01F) << type;
        EXPECT_LT(p.y(), floor + 0.65F) << type;
        if (type == "ball") {
            // In the bowl: its bottom lies 0.3 m up, its rim 1.8 m. Nothing resists rolling, so it
            // goes to and fro for a while, slower than it fell (8 m/s).
            ++balls;
            EXPECT_GT(p.y(), 0.69F);
            EXPECT_LT(p.y(), 1.4F);
            EXPECT_LT(e.velocity[row].norm(), 2.0F);
            return;
        }
        crates_on_hills += floor > 1.0F ? 1 : 0;
        awake += state.scene.state(e.body[row]).asleep ? 0 : 1;
        EXPECT_LT((p - before[e.id[row].value]).norm(), 0.02F);
    });
    EXPECT_EQ(balls, 2);
    EXPECT_GT(crates_on_hills, 0);
    EXPECT_EQ(awake, 0);
}

TEST_F(Hills, GiveTheSameHashWithAnyNumberOfThreads) {
    std::map<unsigned, std::uint64_t> hashes;
    bots.seconds = 4.0;
    for (const unsigned threads : {1U, 2U}) {
        server.threads = threads;
        EXPECT_TRUE(run().consistent);
        hashes[threads] = world->world().state_hash();
    }
    EXPECT_EQ(hashes[1], hashes[2]);
}

TEST_F(Hills, ShareGeometryAmongZonesAndGiveEachWhatReachesIntoIt) {
    config::Settings settings;
    std::vector<config::ConfigError> errors;
    // The bowls lie 75 m from the border and reach 7.5 m: with a margin of 60 m each zone has one.
    ASSERT_TRUE(config::load_settings(kHills,
                                      {"zones.ghost_margin_m=60",
                                       "type[player].aura_m.normal=40",
                                       "type[player].nimbus_m.normal=40"},
                                      settings,
                                      errors))
        << config::format_errors(kHills, errors);
    app::World hills(settings, 1);
    const auto& west = hills.zones()[0]->state().settings;
    const auto& east = hills.zones()[1]->state().settings;
    ASSERT_EQ(west.surfaces.size(), 2u);
    ASSERT_EQ(east.surfaces.size(), 2u);
    EXPECT_EQ(west.surfaces[0].shape.geometry, east.surfaces[0].shape.geometry);
    EXPECT_EQ(&west.statics->surfaces()[1].surface(), &east.statics->surfaces()[1].surface());
    EXPECT_FLOAT_EQ(west.surfaces[0].position.x(), 50.0F);  // zones are centred 50 m off the border
    EXPECT_FLOAT_EQ(east.surfaces[0].position.x(), -50.0F);
    EXPECT_FLOAT_EQ(west.surfaces[1].position.x(), -25.0F);
    EXPECT_FLOAT_EQ(east.surfaces[1].position.x(), 25.0F);
}

TEST_F(Hills, GiveTheSameHashWithEveryBroadphase) {
    std::map<std::string, std::uint64_t> hashes;
    for (const char* kind :
         {"AUTOMATIC", "ALL_PAIRS", "GRID", "OCTREE", "QUADTREE", "SORT_AND_SWEEP", "TREE"}) {
        config::Settings settings;
        std::vector<config::ConfigError> errors;
        ASSERT_TRUE(config::load_settings(kHills,
                                          {std::string("physics.broadphase=") + kind,
                                           "physics.cell_depth=6",
                                           "physics.boxes_per_cell=4"},
                                          settings,
                                          errors));
        app::World hills(settings, 1);
        tick(hills, 150);
        hashes[kind] = hills.state_hash();
    }
    for (const auto& [kind, hash] : hashes) {
        EXPECT_EQ(hash, hashes["AUTOMATIC"]) << kind;
    }
}

}  // namespace
}  // namespace zoned::harness
