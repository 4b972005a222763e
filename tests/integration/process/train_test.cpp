// `zoned train` as users start it: its output, and that an interrupt loses nothing.
#include "tests/integration/process/fixture.h"

#include <chrono>
#include <csignal>
#include <filesystem>
#include <thread>

namespace zoned::testing_process {
namespace {

std::string training(const std::string& folder, const std::string& name, int rounds) {
    const std::string file = folder + "/" + name;
    std::ofstream(file) << "task: ARENA checkpoint_every: 1 hidden { nodes: 8 } rounds: " << rounds
                        << "\n";
    return file;
}

TEST(TrainProcess, InterruptedAndResumedGivesWhatAnUninterruptedRunGives) {
    const std::string folder = scratch_folder();
    constexpr int kRounds = 40;
    Child whole("zoned", {"train", training(folder, "whole", kRounds)});
    ASSERT_EQ(whole.wait(kPatience), 0) << whole.errors();
    const std::string file = training(folder, "parts", kRounds);
    {
        Child parts("zoned", {"train", file});
        // Interrupted as soon as it has made some progress.
        for (int i = 0; i < 6000 && !std::filesystem::exists(file + ".checkpoint"); ++i) {
            std::this_thread::sleep_for(std::chrono::milliseconds(5));
        }
        parts.signal(SIGINT);
        EXPECT_EQ(parts.wait(kPatience), 0) << parts.errors();
        EXPECT_NE(parts.output().find("interrupted after round"), std::string::npos)
            << parts.output();
        EXPECT_FALSE(std::filesystem::exists(file + ".policy"));
    }
    Child refused("zoned", {"train", file});
    EXPECT_EQ(refused.wait(kPatience), 2);
    EXPECT_NE(refused.errors().find("--resume"), std::string::npos);
    Child resumed("zoned", {"train", file, "--resume", "--threads", "2"});
    ASSERT_EQ(resumed.wait(kPatience), 0) << resumed.errors();
    EXPECT_EQ(read(folder + "/whole.policy"), read(file + ".policy"));
    EXPECT_EQ(read(folder + "/whole.checkpoint"), read(file + ".checkpoint"));
}

/// The policies in config/training are what their files say, to the last byte. The policy that
/// imitates players is left out: its recording is of one build.
TEST(TrainProcess, MakesTheShippedPoliciesAnew) {
    for (const char* name : {"arena", "arena_neat"}) {
        const std::string shipped = std::string(ZONED_SOURCE_DIR "/config/training/") + name;
        const std::string file = scratch_folder() + "/" + name + ".txtpb";
        std::ofstream(file) << read(shipped + ".txtpb");
        Child trained("zoned", {"train", file, "--threads", "1"});
        ASSERT_EQ(trained.wait(kPatience), 0) << trained.errors();
        EXPECT_EQ(read(scratch_folder() + "/" + name + ".policy"), read(shipped + ".policy"));
    }
}

TEST(TrainProcess, PrintsMistakesWithTheirPlaceAndExplainsItself) {
    const std::string file = scratch_folder() + "/bad.txtpb";
    std::ofstream(file) << "task: ARENA\nrounds: 0\nmethhod: NEAT\n";
    Child bad("zoned", {"train", file});
    EXPECT_EQ(bad.wait(kPatience), 2);
    EXPECT_NE(bad.errors().find(file + ":2:1: rounds: 0 is out of range"), std::string::npos);
    EXPECT_NE(bad.errors().find(file + ":3:1: methhod"), std::string::npos) << bad.errors();
    Child help("zoned", {"train", "--help"});
    EXPECT_EQ(help.wait(kPatience), 0);
    EXPECT_NE(help.output().find("zoned train config/training/arena.txtpb --resume"),
              std::string::npos);
}

}  // namespace
}  // namespace zoned::testing_process
