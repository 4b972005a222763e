// Worlds that were found at random and broke a promise once.
#include "tests/random_worlds/world_trial.h"

#include <gtest/gtest.h>

#include <ostream>
#include <string>
#include <vector>

namespace zoned::random_worlds {
namespace {

struct FoundWorld {
    const char* name;
    const char* file;
    std::vector<std::string> sets;
    std::uint64_t seed;
};

void PrintTo(const FoundWorld& world, std::ostream* out) {
    *out << world.name;
}

class FoundWorlds : public ::testing::TestWithParam<FoundWorld> {};

TEST_P(FoundWorlds, KeepAllPromises) {
    TrialSettings trial;
    trial.seed = GetParam().seed;
    const ChangedWorld world{std::string(ZONED_SOURCE_DIR "/config/") + GetParam().file,
                             GetParam().sets};
    ASSERT_TRUE(is_accepted(world));
    const TrialOutcome outcome = try_world(world, trial);
    EXPECT_EQ(outcome.finding, Finding::kNone) << name_of(outcome.finding) << outcome.text;
}

INSTANTIATE_TEST_SUITE_P(
    Once,
    FoundWorlds,
    ::testing::Values(
        // Zones that hold nothing but the ground had no snapshot that could be loaded.
        FoundWorld{"zones_of_ground_alone", "hamlet.txtpb", {"zones.zone_grid.rows=32"}, 401293},
        // Next steps of equal cost were those that were found first, and so was the work after
        // them.
        FoundWorld{"equal_ways_around_crowds",
                   "methods/ai_gates.txtpb",
                   {"scatter[0].seed=7"},
                   637030},
        // Where nobody walks, nothing brought the map up to date once a door had turned.
        FoundWorld{"doors_where_nobody_walks",
                   "doors.txtpb",
                   {"zones.zone_grid.columns=12"},
                   668801},
        // Of several publications that clients may still display, one was watched.
        FoundWorld{"a_heartbeat_in_each_tick",
                   "methods/penalty.txtpb",
                   {"replication.heartbeat_ticks=1"},
                   157796}),
    [](const auto& world) { return std::string(world.param.name); });

}  // namespace
}  // namespace zoned::random_worlds
