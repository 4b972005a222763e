// server/run.sh with stand-ins for its programs: exit codes, clean-up, and passed arguments.
#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>

namespace zoned::app {
namespace {

namespace fs = std::filesystem;

/// A repository with the real run.sh and programs whose behaviour the environment sets.
class RunScript : public testing::Test {
  protected:
    void SetUp() override {
        root_ = fs::path(testing::TempDir()) / ("zoned_run_" + std::to_string(getpid()));
        fs::create_directories(root_ / "server");
        fs::create_directories(root_ / "config");
        fs::create_directories(root_ / "build");
        fs::copy_file(ZONED_SOURCE_DIR "/server/run.sh",
                      root_ / "server/run.sh",
                      fs::copy_options::overwrite_existing);
        std::ofstream(root_ / "config/valley.txtpb") << "\n";
        program("config/prepare.sh", "echo prepared \"$@\"; exit ${PREPARE_CODE:-0}");
        program("build/zoned", R"(
            echo "$@" >"$ROOT/served"
            if [[ -n "${SERVER_DIES:-}" ]]; then echo "port in use" >&2; exit "$SERVER_DIES"; fi
            trap 'echo stopped >"$ROOT/stopped"; exit ${SERVER_CODE:-0}' TERM
            echo "ready tcp=4000 udp=4001 admin=4002 zones=4"
            for ((i = 0; i < 200; ++i)); do sleep 0.05; done)");
        program("build/client-sim", "echo client \"$@\"; exit ${CLIENT_CODE:-0}");
    }

    void TearDown() override { fs::remove_all(root_); }

    void program(const std::string& name, const std::string& text) {
        std::ofstream(root_ / name) << "#!/usr/bin/env bash\n" << text << "\n";
        fs::permissions(root_ / name, fs::perms::owner_all);
    }

    /// Runs the script from another folder; its output is in output_ then.
    int run(const std::string& environment, const std::string& arguments) {
        const std::string command =
            "cd / && env -u BOTS -u SECONDS -u CONFIG -u ZONED_BUILD ROOT=" + root_.string() + " " +
            environment + " " + (root_ / "server/run.sh").string() + " " + arguments + " 2>&1";
        std::FILE* pipe = popen(command.c_str(), "r");
        EXPECT_NE(pipe, nullptr);
        output_.clear();
        std::array<char, 512> buffer{};
        while (pipe != nullptr && std::fgets(buffer.data(), buffer.size(), pipe) != nullptr) {
            output_ += buffer.data();
        }
        return WEXITSTATUS(pclose(pipe));
    }

    /// The arguments of the server.
    [[nodiscard]] std::string served() const {
        std::ifstream in(root_ / "served");
        return {std::istreambuf_iterator<char>(in), {}};
    }

    [[nodiscard]] bool printed(const std::string& words) const {
        return output_.find(words) != std::string::npos;
    }

    fs::path root_;
    std::string output_;
};

TEST_F(RunScript, PlaysWithTwoHundredBotsForThirtySecondsAndStopsTheServer) {
    EXPECT_EQ(run("", ""), 0) << output_;
    EXPECT_TRUE(printed("--connect 127.0.0.1:4000 --bots 200 --seconds 30 --report")) << output_;
    EXPECT_TRUE(fs::exists(root_ / "stopped")) << "the server was asked to stop";
}

TEST_F(RunScript, TakesNumbersFromArgumentsAndEnvironmentAndPassesTheRestOn) {
    EXPECT_EQ(run("BOTS=7 SECONDS=9", "-- --loss 5"), 0) << output_;
    EXPECT_TRUE(printed("--bots 7 --seconds 9")) << output_;
    EXPECT_TRUE(printed("--loss 5")) << output_;
    EXPECT_EQ(run("BOTS=7", "--bots 8"), 0);
    EXPECT_TRUE(printed("--bots 8")) << "arguments win";
}

TEST_F(RunScript, LetsAPersonPlayOnceTheClientForBrowsersIsThere) {
    EXPECT_EQ(run("", ""), 0) << output_;
    EXPECT_TRUE(printed("prepared zoned client-sim\n")) << "nobody waits for it: " << output_;
    EXPECT_FALSE(printed("/play")) << output_;
    fs::create_directories(root_ / "build/web");
    std::ofstream(root_ / "build/web/zoned_client.wasm") << "module";
    EXPECT_EQ(run("", ""), 0) << output_;
    EXPECT_TRUE(printed("play in it: http://127.0.0.1:4002/play\n")) << output_;
    // The address is the default one, which is this machine's alone.
    EXPECT_NE(served().find("network.websocket_port=0"), std::string::npos) << served();
    EXPECT_EQ(served().find("address"), std::string::npos) << served();
}

TEST_F(RunScript, EndsWithTheVerdictOfTheClients) {
    EXPECT_EQ(run("CLIENT_CODE=1", ""), 1) << output_;
    EXPECT_TRUE(fs::exists(root_ / "stopped"));
}

TEST_F(RunScript, KeepsTheWorldOpenUntilItIsInterrupted) {
    // A process in the background ignores an interrupt of its shell: the script is sent its own.
    program("interrupted",
            "timeout --foreground --preserve-status --signal=INT 2 \"$ROOT/server/run.sh\" \"$@\"");
    program("build/client-sim", "echo \"$@\" >\"$ROOT/asked\"; exec sleep 20");
    fs::create_directories(root_ / "build/run");
    std::ofstream(root_ / "build/run/admin.token") << "secret";
    const std::string command = "ROOT=" + root_.string() + " bash " +
                                (root_ / "interrupted").string() + " --bots 3 --open 2>&1";
    std::FILE* pipe = popen(command.c_str(), "r");
    ASSERT_NE(pipe, nullptr);
    std::array<char, 512> buffer{};
    while (std::fgets(buffer.data(), buffer.size(), pipe) != nullptr) {
        output_ += buffer.data();
    }
    EXPECT_EQ(WEXITSTATUS(pclose(pipe)), 0) << output_;
    EXPECT_TRUE(printed("look at the world: http://127.0.0.1:4002/#token=secret")) << output_;
    EXPECT_TRUE(printed("until Ctrl-C")) << output_;
    EXPECT_TRUE(printed("prepared zoned client-sim web_client\n")) << output_;
    std::ifstream asked(root_ / "asked");
    const std::string line((std::istreambuf_iterator<char>(asked)), {});
    EXPECT_NE(line.find("--bots 3 --seconds 604800 --no-audit --no-freeze"), std::string::npos);
    EXPECT_TRUE(fs::exists(root_ / "stopped")) << "the server was asked to stop";
}

TEST_F(RunScript, SaysWhyTheServerDidNotStart) {
    EXPECT_EQ(run("SERVER_DIES=2", ""), 2);
    EXPECT_TRUE(printed("port in use")) << output_;
    EXPECT_EQ(run("PREPARE_CODE=3", ""), 3);
}

TEST_F(RunScript, FailsWhenTheServerEndsBadlyAfterAGoodVerdict) {
    EXPECT_EQ(run("SERVER_CODE=4", ""), 4);
    EXPECT_TRUE(printed("exit code 4")) << output_;
}

TEST_F(RunScript, RefusesBadUsage) {
    EXPECT_EQ(run("", "--bots many"), 2);
    EXPECT_EQ(run("", "--bots"), 2);
    EXPECT_EQ(run("", "--nonsense"), 2);
    EXPECT_EQ(run("", "--config /nonexistent"), 2);
    EXPECT_EQ(run("", "--help"), 0);
    EXPECT_TRUE(printed("usage:"));
}

}  // namespace
}  // namespace zoned::app
