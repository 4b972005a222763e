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
