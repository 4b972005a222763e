// Ants in a zone: they find food, find a path home, and find another path when a door shuts.
#include "server/config/expand/load_settings.h"
#include "tests/integration/plain/crowd_world.h"

#include <gmock/gmock.h>

namespace zoned::app {
namespace {

using test::Crowd;
using test::with;

/// A nest, and crumbs 10 m from it, with a wall halfway between. The wall has a gap of 1 m, 2 m
/// beside the straight line, and another one 7 m beside it on the other side. `door` may shut the
/// nearer one.
std::string ant_hill(const std::string& door, int seed = 5) {
    return R"(
world { name: "hill" seed: )" +
           std::to_string(seed) +
           R"( tick_rate_hz: 20 min_x_m: -40 min_z_m: -40 max_x_m: 40 max_z_m: 40 }
zones { zone_grid { columns: 1 rows: 1 } }
replication { silence_ticks: 10 }
ai { suspend_offscreen: false }
point_of_interest { name: "nest" x_m: -5 z_m: 0 radius_m: 1 }
point_of_interest { name: "crumbs" x_m: 5 z_m: 0 radius_m: 1 }
type { name: "player" kind: CHARACTER capsule { radius_m: 0.4 length_m: 1 } aura_m { normal: 50 } nimbus_m { normal: 50 } character { } }
type { name: "ant" kind: CHARACTER capsule { radius_m: 0.1 length_m: 0.1 } aura_m { normal: 10 } character { speed_mps: 1 acceleration_mps2: 10 } brain: "ant" }
brain { name: "ant" state { name: "forage" action: FORAGE forage { nest: "nest" food: "crumbs" radius_m: 14 cell_m: 0.5 patience: 400 evaporation_per_s: 0.01 } } }
statics {
  box { x_m: 0 y_m: 0.5 z_m: 5 size { x_m: 0.4 y_m: 1 z_m: 5 } }
  box { x_m: 0 y_m: 0.5 z_m: -2.75 size { x_m: 0.4 y_m: 1 z_m: 8.5 } }
  box { x_m: 0 y_m: 0.5 z_m: -12 size { x_m: 0.4 y_m: 1 z_m: 8 } }
  box { x_m: 0 y_m: 0.5 z_m: 12.5 size { x_m: 0.4 y_m: 1 z_m: 10 } }
}
scatter { type: "ant" count: 60 seed: 1 min_distance_m: 0.3 region { min_x_m: -8 max_x_m: -2.5 min_z_m: -3 max_z_m: 3 } }
spawn { x_m: 0 z_m: 35 }
lod { position_bound_m: 0.5 orientation_bound_rad: 0.3 }
session { dev_mode_loopback: true }
)" + door;
}

/// The food brought home in so many seconds.
std::uint64_t brought_in(Crowd& crowd, int seconds) {
    const std::uint64_t before = crowd.state().ai_update.nests().delivered();
    for (int t = 0; t < seconds * 20; ++t) {
        crowd.tick();
    }
    return crowd.state().ai_update.nests().delivered() - before;
}

/// Ants on either side of the wall near a gap, by its z.
int near_gap(Crowd& crowd, float z) {
    int count = 0;
    for (world::Row row = 0; row < crowd.state().entities.size(); ++row) {
        count += (crowd.at(row) - Vec2(0.0F, z)).norm() < 1.5F ? 1 : 0;
    }
    return count;
}

TEST(Forage, AntsBringFoodHomeAndMoreOnceTheyKnowTheWay) {
    // One run brings 57 to 75, with a deviation of 7: the mean of eight is known to within 3.
    constexpr std::uint64_t kRuns = 8;
    std::uint64_t first = 0;
    std::uint64_t later = 0;
    for (int seed = 1; seed <= static_cast<int>(kRuns); ++seed) {
        Crowd crowd(ant_hill("", seed));
        first += brought_in(crowd, 120);
        brought_in(crowd, 240);
        later += brought_in(crowd, 120);
    }
    RecordProperty("later", static_cast<int>(later));
    EXPECT_GT(later, 2 * std::max<std::uint64_t>(first, 1));
    // There and back is 24 m: an ant that walks straight brings five in two minutes.
    EXPECT_GT(later, 60U * kRuns) << "of 300 that 60 could bring at most in each";
    EXPECT_LE(later, 300U * kRuns);
}

TEST(Forage, WhenADoorShutsTheyFindAnotherWay) {
    // The nearer gap is at z = 2.
    Crowd crowd(ant_hill(R"(
door { name: "gap" box { x_m: 0 y_m: 0.5 z_m: 2 size { x_m: 0.4 y_m: 1 z_m: 1 } } period_s: 100000 open { from_s: 0 to_s: 400 } }
)"));
    brought_in(crowd, 300);
    const std::uint64_t open = brought_in(crowd, 90);
    int near = 0;
    int far = 0;
    for (int k = 0; k < 8; ++k) {
        brought_in(crowd, 1);
        near += near_gap(crowd, 2.0F);
        far += near_gap(crowd, -7.5F);
    }
    EXPECT_GT(near, 2 * far) << "the nearer gap is the street";
    // By the nearer gap it is 21 m there and back, by the other one 36 m. 60 ants that walk
    // straight bring 257 in 90 s, and 300 in 180 s. A twentieth of that is asked of ants that
    // follow scents, scout and stray.
    EXPECT_GT(open, 257U / 20U);
    RecordProperty("open", static_cast<int>(open));
    // It shuts; the old scents go, and a new street grows.
    brought_in(crowd, 900);
    const std::uint64_t shut = brought_in(crowd, 180);
    EXPECT_GT(shut, 300U / 20U);
    RecordProperty("shut", static_cast<int>(shut));
}

/// Here ants do not hold each other up, nor do walls hold up an ant that goes from cell to cell. So
/// the food they bring follows from their timetables alone.
TEST(Forage, AntsThatNobodySeesBringWhatTheyWouldHaveBrought) {
    Crowd seen(ant_hill(""));
    Crowd unseen(with(ant_hill(""), "suspend_offscreen: false", "suspend_offscreen: true"));
    for (int minute = 1; minute <= 5; ++minute) {
        EXPECT_EQ(brought_in(seen, 60), brought_in(unseen, 60)) << "in minute " << minute;
    }
    EXPECT_TRUE(unseen.state().agents.active().empty());
    EXPECT_GT(unseen.state().ai_update.nests().delivered(), 60U);
}

TEST(Forage, GivesTheSameHashForOneAndFourThreads) {
    Crowd one(ant_hill(""), 1U);
    Crowd four(ant_hill(""), 4U);
    EXPECT_EQ(brought_in(one, 60), brought_in(four, 60));
    EXPECT_EQ(one.world().state_hash(), four.world().state_hash());
}

TEST(Forage, IsCheckedWithLineAndColumn) {
    const auto mistakes = [](const std::string& from, const std::string& to) {
        config::Settings settings;
        std::vector<config::ConfigError> errors;
        EXPECT_FALSE(config::parse_settings(with(ant_hill(""), from, to), {}, settings, errors));
        return config::format_errors("hill", errors);
    };
    EXPECT_THAT(mistakes("nest: \"nest\"", ""), testing::HasSubstr("nowhere to bring food"));
    EXPECT_THAT(mistakes("food: \"crumbs\"", "food: \"cake\""), testing::HasSubstr("named 'cake'"));
    EXPECT_THAT(mistakes("radius_m: 14", "radius_m: 9"), testing::HasSubstr("farther than"));
    EXPECT_THAT(mistakes("action: FORAGE", "action: IDLE"), testing::HasSubstr("hill:10:57"));
}

}  // namespace
}  // namespace zoned::app
