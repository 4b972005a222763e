// Crowds of agents in a zone: they pass each other, clear corridors and doorways, never overlap.
#include "tests/integration/plain/crowd_world.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <string>

namespace zoned::app {
namespace {

using test::Crowd;
using test::kRadius;
using test::with;

/// Walkers of type "shuttle" go from the place "west" to "east" and back for ever. Those of
/// "return" go in the opposite direction; "stay" stand. `more`: statics, scatters.
std::string crowd_world(const std::string& avoidance, const std::string& more) {
    return R"(
world { name: "crowd" seed: 3 tick_rate_hz: 30 min_x_m: -60 min_z_m: -60 max_x_m: 60 max_z_m: 60 }
zones { zone_grid { columns: 1 rows: 1 } }
ai { suspend_offscreen: false )" +
           avoidance + R"( }
point_of_interest { name: "west" x_m: -20 z_m: 0 radius_m: 1.5 }
point_of_interest { name: "east" x_m: 20 z_m: 0 radius_m: 1.5 }
type { name: "player" kind: CHARACTER capsule { radius_m: 0.4 length_m: 1 } aura_m { normal: 50 } nimbus_m { normal: 50 } character { speed_mps: 3 } }
type { name: "shuttle" base: "player" brain: "shuttle" character { speed_mps: 1.5 } }
type { name: "return" base: "player" brain: "return" character { speed_mps: 1.5 } }
type { name: "stay" base: "player" brain: "stay" character { speed_mps: 1.5 } }
type { name: "crate" box { x_m: 0.8 y_m: 0.8 z_m: 0.8 } mass_kg: 200 }
brain {
  name: "shuttle"
  state { name: "to_east" action: GO point_of_interest: "east" transition { to: "to_west" sense: "east.distance" compare: BELOW threshold: 2 } }
  state { name: "to_west" action: GO point_of_interest: "west" transition { to: "to_east" sense: "west.distance" compare: BELOW threshold: 2 } }
}
brain {
  name: "return"
  state { name: "to_west" action: GO point_of_interest: "west" transition { to: "to_east" sense: "west.distance" compare: BELOW threshold: 2 } }
  state { name: "to_east" action: GO point_of_interest: "east" transition { to: "to_west" sense: "east.distance" compare: BELOW threshold: 2 } }
}
brain { name: "stay" state { name: "stand" action: IDLE } }
spawn { x_m: 0 z_m: 50 }
lod { position_bound_m: 0.5 orientation_bound_rad: 0.3 }
session { dev_mode_loopback: true }
)" + more;
}

const char* const kOn = "avoidance { }";
/// A corridor of 4 m from -25 m to 25 m.
const char* const kCorridor = R"(
statics {
  box { x_m: 0 y_m: 1 z_m: 2.5 size { x_m: 50 y_m: 2 z_m: 1 } }
  box { x_m: 0 y_m: 1 z_m: -2.5 size { x_m: 50 y_m: 2 z_m: 1 } }
})";
/// A wall across with a door of 1.6 m, in a hall of 12 m.
const char* const kDoorway = R"(
statics {
  box { x_m: 0 y_m: 1 z_m: 3.4 size { x_m: 0.5 y_m: 2 z_m: 5.2 } }
  box { x_m: 0 y_m: 1 z_m: -3.4 size { x_m: 0.5 y_m: 2 z_m: 5.2 } }
  box { x_m: 0 y_m: 1 z_m: 6.5 size { x_m: 60 y_m: 2 z_m: 1 } }
  box { x_m: 0 y_m: 1 z_m: -6.5 size { x_m: 60 y_m: 2 z_m: 1 } }
})";

TEST(LocalAvoidance, TwoHeadingAtEachOtherPassAndReachTheirPlaces) {
    Crowd crowd(crowd_world(kOn, ""), {{"shuttle", {-18.0F, 0.0F}}, {"return", {18.0F, 0.0F}}});
    const float way = 36.0F;
    bool met = false;
    // Alone they would take path length / speed; they may lose 3 s to each other.
    for (int t = 0; t < static_cast<int>((way / 1.5F + 3.0F) * 30.0F); ++t) {
        crowd.tick();
        met = met || crowd.overlap() > -1.0F;
        ASSERT_LE(crowd.overlap(), 0.0F) << "tick " << t;
    }
    EXPECT_TRUE(met);
    EXPECT_GT(crowd.at(0).x(), 12.0F) << "it is there, or already on its way back";
    EXPECT_LT(crowd.at(1).x(), -12.0F);
}

TEST(LocalAvoidance, WithoutItTheyWalkThroughEachOther) {
    // The measure of overlap is checked too.
    Crowd crowd(crowd_world("", ""), {{"shuttle", {-18.0F, 0.0F}}, {"return", {18.0F, 0.0F}}});
    float most = -1.0F;
    for (int t = 0; t < 600; ++t) {
        crowd.tick();
        most = std::max(most, crowd.overlap());
    }
    EXPECT_GT(most, 0.5F * kRadius);
}

TEST(LocalAvoidance, WhoStandsInAWallIsSeenThere) {
    // The measure of walls is checked too: before the first tick no walker was moved out.
    Crowd crowd(crowd_world(kOn, kCorridor), {{"stay", {0.0F, 2.2F}}});
    EXPECT_GT(crowd.in_walls(), 0.5F * kRadius);
}

TEST(LocalAvoidance, WhoMeetsNobodyIsSteeredBitForBitAsWithout) {
    // 6 m apart, walking in the same direction: seen, but never met.
    const std::vector<std::pair<std::string, Vec2>> walkers = {{"shuttle", {-18.0F, -1.4F}},
                                                               {"shuttle", {-14.0F, 1.4F}}};
    Crowd with(crowd_world(kOn, ""), walkers);
    Crowd without(crowd_world("", ""), walkers);
    for (int t = 0; t < 300; ++t) {
        with.tick();
        without.tick();
        ASSERT_EQ(with.avoidance().crowded, 0U);
        for (world::Row row = 0; row < 2; ++row) {
            ASSERT_EQ(with.state().entities.command[row], without.state().entities.command[row]);
        }
    }
    EXPECT_EQ(with.world().state_hash(), without.world().state_hash());
}

/// Counts how often walkers came to the far side: x beyond +-12 m after the other.
class Crossings {
  public:
    void look(Crowd& crowd) {
        sides_.resize(crowd.state().entities.size(), 0);
        for (world::Row row = 0; row < sides_.size(); ++row) {
            const float x = crowd.at(row).x();
            const int side = x > 12.0F ? 1 : (x < -12.0F ? -1 : 0);
            if (side != 0 && side == -sides_[row]) {
                ++count_;
            }
            sides_[row] = side != 0 ? side : sides_[row];
        }
    }

    [[nodiscard]] int count() const { return count_; }

  private:
    std::vector<int> sides_;
    int count_ = 0;
};

TEST(LocalAvoidance, NobodyOverlapsNorEntersWallsInACorridorWithCounterflow) {
    Crowd crowd(crowd_world(kOn, std::string(kCorridor) + R"(
scatter { type: "shuttle" count: 14 seed: 1 min_distance_m: 1 region { min_x_m: -20 max_x_m: -6 min_z_m: -1.5 max_z_m: 1.5 } }
scatter { type: "return" count: 14 seed: 2 min_distance_m: 1 region { min_x_m: 6 max_x_m: 20 min_z_m: -1.5 max_z_m: 1.5 } }
)"));
    Crossings crossings;
    float overlap = -1.0F;
    float in_walls = -1.0F;
    std::uint64_t crowded = 0;
    for (int t = 0; t < 10000; ++t) {
        crowd.tick();
        crossings.look(crowd);
        overlap = std::max(overlap, crowd.overlap());
        in_walls = std::max(in_walls, crowd.in_walls());
        crowded += crowd.avoidance().crowded;
    }
    EXPECT_GT(crowded, 10000U);
    EXPECT_LE(overlap, 0.02F * kRadius);
    EXPECT_LE(in_walls, 1e-3F);
    // Alone each would cross 10000 / 30 s / (36 m / 1.5 m/s) = 14 times: at least a third of it.
    EXPECT_GT(crossings.count(), 28 * 14 / 3);
    RecordProperty("crossings", crossings.count());
}

TEST(LocalAvoidance, ADoorwayWithCounterflowClears) {
    Crowd crowd(crowd_world(kOn, std::string(kDoorway) + R"(
scatter { type: "shuttle" count: 12 seed: 1 min_distance_m: 1 region { min_x_m: -20 max_x_m: -8 min_z_m: -3 max_z_m: 3 } }
scatter { type: "return" count: 12 seed: 2 min_distance_m: 1 region { min_x_m: 8 max_x_m: 20 min_z_m: -3 max_z_m: 3 } }
)"));
    Crossings crossings;
    float overlap = -1.0F;
    float in_walls = -1.0F;
    for (int t = 0; t < 10000; ++t) {
        crowd.tick();
        crossings.look(crowd);
        overlap = std::max(overlap, crowd.overlap());
        in_walls = std::max(in_walls, crowd.in_walls());
    }
    EXPECT_LE(overlap, 0.02F * kRadius);
    EXPECT_LE(in_walls, 1e-3F);
    EXPECT_GT(crossings.count(), 24 * 4);
    RecordProperty("crossings", crossings.count());
}

/// The most by which any two overlap in 10^4 ticks.
float overlap_of_slow_brakers(const std::string& statics) {
    // At 4 m/s and 3 m/s2: 2.7 m, more than the corridor is wide for two.
    std::string text = crowd_world(kOn, statics + R"(
scatter { type: "shuttle" count: 8 seed: 1 min_distance_m: 1.5 region { min_x_m: -20 max_x_m: -6 min_z_m: -1.5 max_z_m: 1.5 } }
scatter { type: "return" count: 8 seed: 2 min_distance_m: 1.5 region { min_x_m: 6 max_x_m: 20 min_z_m: -1.5 max_z_m: 1.5 } }
)");
    for (const char* type : {"shuttle", "return"}) {
        text = with(
            text,
            std::string("brain: \"") + type + "\" character { speed_mps: 1.5",
            std::string("brain: \"") + type + "\" character { speed_mps: 4 acceleration_mps2: 3");
    }
    Crowd crowd(text);
    Crossings crossings;
    float overlap = -1.0F;
    for (int t = 0; t < 10000; ++t) {
        crowd.tick();
        crossings.look(crowd);
        overlap = std::max(overlap, crowd.overlap());
    }
    EXPECT_GT(crossings.count(), 16 * 4);
    return overlap;
}

TEST(LocalAvoidance, WhoTakesMetresToStopOverlapsNobodyEither) {
    EXPECT_LE(overlap_of_slow_brakers(""), 0.02F * kRadius) << "in the open";
    EXPECT_LE(overlap_of_slow_brakers(kCorridor), 0.02F * kRadius) << "in a corridor";
}

TEST(LocalAvoidance, ACrateThatHitsAWalkerPushesItAndAWallHoldsIt) {
    // A crate of 200 kg at 6 m/s against a man of 80 kg, 1.5 m before a thin wall.
    const std::string wall =
        "statics { box { x_m: 2.5 y_m: 1 z_m: 0 size { x_m: 0.1 y_m: 2 z_m: 20 } } }";
    Crowd crowd(crowd_world(kOn, wall), {{"stay", {0.6F, 0.0F}}, {"crate", {-1.5F, 0.0F}}});
    crowd.tick();
    zone::ZoneState& state = crowd.state();
    state.scene.set_velocity(state.entities.body[1], Vec3(6.0F, 0.0F, 0.0F), Vec3::Zero());
    float farthest = 0.0F;
    for (int t = 0; t < 120; ++t) {
        crowd.tick();
        farthest = std::max(farthest, crowd.at(0).x());
    }
    // Two free bodies would part at 6 * 200 / 280 m/s and more; it brakes at 20 m/s2.
    EXPECT_GT(farthest, 0.6F + 0.2F);
    EXPECT_LE(farthest, 2.45F - kRadius + 1e-3F);
}

TEST(LocalAvoidance, WhoIsNotSimulatedIsPutWhereItStandsClearOfWalls) {
    // The places are behind a wall without a door: walkers meet it and go along it while they are
    // off-screen.
    const std::string wall = R"(
statics {
  box { x_m: 0 y_m: 1 z_m: 0 size { x_m: 3 y_m: 2 z_m: 50 } }
  box { x_m: 20 y_m: 1 z_m: 0 size { x_m: 1 y_m: 2 z_m: 1 } }
})";
    Crowd crowd(with(crowd_world(kOn, wall + R"(
scatter { type: "shuttle" count: 40 seed: 1 min_distance_m: 1 region { min_x_m: -30 max_x_m: -3 min_z_m: -8 max_z_m: 8 } }
)"),
                     "suspend_offscreen: false",
                     "suspend_offscreen: true"));
    float in_walls = -1.0F;
    std::uint32_t suspended = 0;
    for (int t = 0; t < 3000; ++t) {
        crowd.tick();
        in_walls = std::max(in_walls, crowd.in_walls());
        suspended = std::max(suspended, 40U - crowd.world().zones().front()->report().ai.active);
    }
    EXPECT_EQ(suspended, 40U);
    EXPECT_LE(in_walls, 1e-3F);
}

TEST(LocalAvoidance, GivesTheSameHashForOneTwoAndFourThreads) {
    const std::string text = crowd_world(kOn, std::string(kCorridor) + R"(
scatter { type: "shuttle" count: 20 seed: 1 min_distance_m: 1 region { min_x_m: -20 max_x_m: -3 min_z_m: -1.5 max_z_m: 1.5 } }
scatter { type: "return" count: 20 seed: 2 min_distance_m: 1 region { min_x_m: 3 max_x_m: 20 min_z_m: -1.5 max_z_m: 1.5 } }
)");
    std::vector<std::uint64_t> hashes;
    for (const unsigned threads : {1U, 2U, 4U}) {
        Crowd crowd(text, threads);
        for (int t = 0; t < 600; ++t) {
            crowd.tick();
        }
        hashes.push_back(crowd.world().state_hash());
    }
    EXPECT_EQ(hashes[0], hashes[1]);
    EXPECT_EQ(hashes[0], hashes[2]);
}

}  // namespace
}  // namespace zoned::app
