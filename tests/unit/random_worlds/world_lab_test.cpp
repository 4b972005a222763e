#include "tests/random_worlds/world_lab.h"

#include <gtest/gtest.h>

#include <csignal>
#include <cstdlib>
#include <stdexcept>

namespace zoned::random_worlds {
namespace {

LabSettings small_lab() {
    LabSettings settings;
    settings.files = {ZONED_SOURCE_DIR "/config/minimal.txtpb",
                      ZONED_SOURCE_DIR "/config/solids.txtpb"};
    settings.trial.bots = 3;
    settings.trial.seconds = 2.0;
    return settings;
}

TEST(RandomWorlds, AreTheSameForTheSameNumber) {
    const LabSettings settings = small_lab();
    const WorldChanger changer(settings.files);
    const LabEntry one = draw_entry(changer, settings, 7);
    const LabEntry again = draw_entry(changer, settings, 7);
    EXPECT_EQ(command_of(one.world), command_of(again.world));
    EXPECT_NE(command_of(one.world), command_of(draw_entry(changer, settings, 8).world));
}

TEST(RandomWorlds, AreAcceptedByTheChecksAndChanged) {
    const LabSettings settings = small_lab();
    const WorldChanger changer(settings.files);
    std::size_t changes = 0;
    for (std::uint64_t number = 0; number < 8; ++number) {
        const LabEntry entry = draw_entry(changer, settings, number);
        EXPECT_TRUE(is_accepted(entry.world)) << command_of(entry.world);
        changes += entry.world.sets.size();
    }
    EXPECT_GE(changes, 8U);
}

TEST(RandomWorlds, AreReducedToTheChangeThatBreaksAPromise) {
    const std::string fault = "testing.corrupt_position={ probability: 1 }";
    const ChangedWorld world{
        ZONED_SOURCE_DIR "/config/minimal.txtpb",
        {"type[crate].mass_kg=20", "interest.hysteresis=0.2", fault, "world.seed=3"}};
    const TrialSettings trial = small_lab().trial;
    const TrialOutcome outcome = try_world(world, trial);
    ASSERT_EQ(outcome.finding, Finding::kInconsistent) << outcome.text;
    const ChangedWorld reduced = reduce(world, trial, outcome.finding, 20);
    ASSERT_EQ(reduced.sets.size(), 1U) << command_of(reduced);
    EXPECT_EQ(reduced.sets.front(), fault);
}

TEST(RandomWorlds, AZoneWhoseRulesThrowIsAFinding) {
    const ChangedWorld world{ZONED_SOURCE_DIR "/config/minimal.txtpb",
                             {"testing.break_zone={ at_tick: 20 }"}};
    EXPECT_EQ(try_world(world, small_lab().trial).finding, Finding::kStopped);
}

TEST(RandomWorlds, AReadAnewScriptThatStopsAZoneIsAFindingAndIsReduced) {
    const std::string stops = R"(script={ text: "function on_tick() error('now') end" )"
                              "errors_allowed: 0 on_errors: SCRIPT_STOP_ZONE }";
    const ChangedWorld world{
        ZONED_SOURCE_DIR "/config/arena.txtpb", {"world.seed=3"}, {"ai.unknown_setting=1", stops}};
    EXPECT_FALSE(brains_of_reload(world).ok());
    ChangedWorld taken = world;
    taken.reload = {stops};
    ASSERT_TRUE(brains_of_reload(taken).ok()) << brains_of_reload(taken).error();
    const TrialSettings trial = small_lab().trial;
    const TrialOutcome outcome = try_world(taken, trial);
    ASSERT_EQ(outcome.finding, Finding::kStopped) << outcome.text;
    const ChangedWorld reduced = reduce(taken, trial, outcome.finding, 20);
    EXPECT_TRUE(reduced.sets.empty()) << command_of(reduced);
    EXPECT_EQ(reduced.reload, taken.reload);
}

TEST(RandomWorlds, GetReloadsThatARunningServerTakes) {
    LabSettings settings = small_lab();
    settings.files = {ZONED_SOURCE_DIR "/config/hamlet.txtpb"};
    const WorldChanger changer(settings.files);
    std::size_t reloads = 0;
    for (std::uint64_t number = 0; number < 6; ++number) {
        const LabEntry entry = draw_entry(changer, settings, number);
        reloads += entry.world.reload.empty() ? 0 : 1;
        EXPECT_TRUE(entry.world.reload.empty() || brains_of_reload(entry.world).ok())
            << command_of(entry.world);
    }
    EXPECT_GE(reloads, 1U);
}

TEST(RandomWorlds, ACrashIsAFinding) {
    const ChangedWorld world{ZONED_SOURCE_DIR "/config/minimal.txtpb",
                             {"testing.break_zone={ at_tick: 20 kind: ABORT }"}};
    const TrialOutcome outcome = try_world(world, small_lab().trial);
    EXPECT_EQ(outcome.finding, Finding::kCrash) << outcome.text;
}

TEST(ForkedWork, ReturnsWhatItsFunctionSays) {
    ForkedWork work([] { return std::string(100000, 'x'); }, 0.0);
    const ForkedResult result = work.finish();
    EXPECT_TRUE(result.ended);
    EXPECT_EQ(result.text.size(), 100000U);
}

TEST(ForkedWork, NamesTheSignalThatEndedIt) {
    ForkedWork work([]() -> std::string { std::abort(); }, 0.0);
    const ForkedResult result = work.finish();
    EXPECT_FALSE(result.ended);
    EXPECT_EQ(result.signal, SIGABRT);
}

TEST(ForkedWork, SaysWhatItsFunctionThrew) {
    ForkedWork work([]() -> std::string { throw std::runtime_error("no such world"); }, 0.0);
    const ForkedResult result = work.finish();
    EXPECT_FALSE(result.ended);
    EXPECT_NE(result.text.find("no such world"), std::string::npos);
}

}  // namespace
}  // namespace zoned::random_worlds
