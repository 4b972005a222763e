#include "server/app/commands/commands.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>

namespace zoned::app {
namespace {

class Train : public ::testing::Test {
  protected:
    Train() {
        folder_ = std::filesystem::temp_directory_path().string() + "/zoned_train_" +
                  ::testing::UnitTest::GetInstance()->current_test_info()->name();
        std::filesystem::remove_all(folder_);
        std::filesystem::create_directories(folder_);
    }

    /// Writes a training file and runs the command on it.
    int run(const std::string& name,
            const std::string& text,
            bool resume = false,
            bool restart = false,
            unsigned threads = 1) {
        std::ofstream(path(name), std::ios::binary) << text;
        return train({path(name), resume, restart, threads});
    }

    [[nodiscard]] std::string path(const std::string& name) const { return folder_ + "/" + name; }

    [[nodiscard]] std::string text_of(const std::string& name) const {
        std::ifstream in(path(name), std::ios::binary);
        std::stringstream text;
        text << in.rdbuf();
        return text.str();
    }

    /// The policy without its digest and how it was trained.
    [[nodiscard]] std::string network_of(const std::string& name) const {
        const std::string text = text_of(name);
        const std::size_t at = text.find("network");
        return at == std::string::npos ? std::string() : text.substr(at);
    }

    static std::string arena(int rounds, const std::string& more = "hidden { nodes: 4 }") {
        return "task: ARENA seed: 5 checkpoint_every: 3 rounds: " + std::to_string(rounds) + " " +
               more;
    }

  private:
    std::string folder_;
};

TEST_F(Train, GivesTheSamePolicyForAnyNumberOfThreadsAndAnotherForAnotherSeed) {
    EXPECT_EQ(run("one", arena(4)), kGood);
    EXPECT_EQ(run("three", arena(4), false, false, 3), kGood);
    EXPECT_EQ(run("other", "seed: 6 task: ARENA rounds: 4 hidden { nodes: 4 }"), kGood);
    EXPECT_GT(network_of("one.policy").size(), 200u);
    EXPECT_EQ(text_of("one.policy"), text_of("three.policy"));
    EXPECT_NE(network_of("one.policy"), network_of("other.policy"));
}

TEST_F(Train, ResumedGivesBitForBitWhatAnUninterruptedOneGives) {
    for (const std::string method : {"method: GENETIC hidden { nodes: 4 }",
                                     "method: NEAT neat { population: 20 add_node: 0.3 }"}) {
        EXPECT_EQ(run("whole", arena(7, method), false, true), kGood);
        EXPECT_EQ(run("parts", arena(2, method), false, true), kGood);
        EXPECT_EQ(run("parts", arena(3, method), true), kGood);
        EXPECT_EQ(run("parts", arena(7, method), true), kGood);
        EXPECT_EQ(text_of("whole.policy"), text_of("parts.policy"));
        EXPECT_EQ(text_of("whole.checkpoint"), text_of("parts.checkpoint"));
    }
}

TEST_F(Train, KeepsACheckpointThatNobodyAskedToReplace) {
    EXPECT_EQ(run("t", arena(2)), kGood);
    EXPECT_EQ(run("t", arena(2)), kUsage);
    EXPECT_EQ(run("t", arena(2), false, true), kGood);
    // Another training refuses to go on from it. A damaged or missing checkpoint is refused too.
    EXPECT_EQ(run("t", arena(2, "hidden { nodes: 5 }"), true), kUsage);
    std::string bytes = text_of("t.checkpoint");
    bytes[bytes.size() / 2] = static_cast<char>(bytes[bytes.size() / 2] ^ 1);
    std::ofstream(path("t.checkpoint"), std::ios::binary) << bytes;
    EXPECT_EQ(run("t", arena(2), true), kEnvironment);
    std::filesystem::remove(path("t.checkpoint"));
    EXPECT_EQ(run("t", arena(2), true), kEnvironment);
}

TEST_F(Train, SaysByItsExitCodeWhetherTheTargetWasReached) {
    EXPECT_EQ(run("pole", "task: CART_POLE method: NEAT target_score: 475"), kGood);
    EXPECT_EQ(run("far", arena(1, "target_score: 1000")), kFailed);
    EXPECT_EQ(run("xor", "task: XOR method: NEAT target_score: 4 rounds: 300"), kGood);
    // A network without hidden nodes cannot.
    EXPECT_EQ(run("flat", "task: XOR target_score: 4 rounds: 20"), kFailed);
    EXPECT_EQ(run("bad", "task: XOR rounds: 0"), kUsage);
    EXPECT_EQ(run("none",
                  "task: IMITATION method: GRADIENT imitation { recording: \"no.zrec\" "
                  "input { } }"),
              kEnvironment);
}

}  // namespace
}  // namespace zoned::app
