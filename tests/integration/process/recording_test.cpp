// Recordings of a real server: what a killed one leaves, cuts, damage, a disk that fills.
#include "tests/integration/process/fixture.h"

#include <gmock/gmock.h>
#include <sys/mount.h>

#include <algorithm>
#include <chrono>
#include <csignal>
#include <filesystem>
#include <thread>

namespace zoned::testing_process {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

class Recorded : public Process {
  protected:
    /// Exit code of `zoned replay` with these arguments; its output is kept.
    int replay(const std::vector<std::string>& arguments) {
        std::vector<std::string> all{"replay"};
        all.insert(all.end(), arguments.begin(), arguments.end());
        Child child("zoned", all);
        const int code = child.wait(kPatience);
        out = child.output();
        errors = child.errors();
        return code;
    }

    /// A recording of two seconds with bots.
    std::string record() {
        const std::string file = scratch_folder() + "/run.zrec";
        const auto server = start_server({"--set", "recording.file=\"" + file + "\""});
        Child client("client-sim", play(4, 2));
        EXPECT_EQ(client.wait(kPatience), 0) << client.output();
        server->signal(SIGTERM);
        EXPECT_EQ(server->wait(kPatience), 0) << server->errors();
        return file;
    }

    std::string out;
    std::string errors;
};

TEST_F(Recorded, LastInputsOfAKilledServerAreReplayedAndKeptByTheNext) {
    {
        const auto server = start_server();
        Child client("client-sim", play(3, 30));
        EXPECT_EQ(client.wait(3.0), -1);
        server->signal(SIGKILL);
        EXPECT_EQ(server->wait(kPatience), 128 + SIGKILL);
    }
    const std::string ring = scratch_folder() + "/ring";
    EXPECT_EQ(replay({ring, "--threads", "2"}), 1);
    EXPECT_THAT(out, HasSubstr("every hash agrees"));
    EXPECT_THAT(errors, HasSubstr("ends without an end mark"));
    EXPECT_GT(number_after(out, "replayed "), 30);

    const auto next = start_server();
    ASSERT_TRUE(next->wait_for_errors("an earlier run did not end in good order", kPatience))
        << next->errors();
    std::string kept;  // the newest: names hold the time
    for (const auto& entry : fs::directory_iterator(scratch_folder())) {
        if (entry.path().filename().string().starts_with("ring-")) {
            kept = std::max(kept, entry.path().string());
        }
    }
    ASSERT_FALSE(kept.empty());
    EXPECT_THAT(next->errors(), HasSubstr("zoned replay " + kept));
    EXPECT_EQ(replay({kept}), 1);
    EXPECT_THAT(out, HasSubstr("every hash agrees"));
    next->signal(SIGTERM);
    EXPECT_EQ(next->wait(kPatience), 0);
    EXPECT_TRUE(fs::is_empty(ring)) << "a server that ends well leaves none";
}

TEST_F(Recorded, ALongRunIsReplayedFromTheStateBesideItsLastInputs) {
    const std::string ring = scratch_folder() + "/ring";
    {
        // 18 ticks in pieces of five: a state seldom falls on the end of a piece.
        const auto server = start_server({"--set", "recording.ring_s=0.6"});
        Child client("client-sim", play(4, 30));
        EXPECT_EQ(client.wait(5.0), -1);
        server->signal(SIGKILL);
        EXPECT_EQ(server->wait(kPatience), 128 + SIGKILL);
    }
    EXPECT_EQ(replay({ring, "--threads", "2"}), 1);
    EXPECT_THAT(out, HasSubstr("every hash agrees")) << errors;
    EXPECT_THAT(errors, HasSubstr("ends without an end mark"));
    // Half a second or more, and not the 150 ticks and more of the whole run.
    EXPECT_GE(number_after(out, "replayed "), 15) << out;
    EXPECT_LT(number_after(out, "replayed "), 120) << out;
    EXPECT_EQ(replay({ring, "--info"}), 1);
    EXPECT_THAT(out, HasSubstr("with the state of tick")) << out;
    std::vector<fs::path> states;
    for (const auto& entry : fs::directory_iterator(ring)) {
        if (entry.path().string().ends_with("-state.zrec")) {
            states.push_back(entry.path());
        }
    }
    EXPECT_GE(states.size(), 2U);
    EXPECT_LE(states.size(), 3U) << "one may just have come";
    // Without them.
    for (const fs::path& state : states) {
        fs::remove(state);
    }
    EXPECT_EQ(replay({ring}), 1);
    EXPECT_THAT(errors, HasSubstr("begins with tick"));
    EXPECT_THAT(errors, HasSubstr("the state of the world before that tick"));
    EXPECT_EQ(replay({ring, "--info"}), 1);
    EXPECT_THAT(out, HasSubstr("config digest"));
}

TEST_F(Recorded, RunsAreCutAndDescribed) {
    const std::string file = record();
    const std::string part = scratch_folder() + "/part.zrec";
    EXPECT_EQ(replay({file, "--info"}), 0) << errors;
    EXPECT_THAT(out, HasSubstr("in good order"));
    EXPECT_EQ(replay({file, "--to", "30", "--out", part}), 0) << errors;
    EXPECT_EQ(replay({part}), 0) << errors;
    EXPECT_THAT(out, HasSubstr("replayed 30 ticks"));
    EXPECT_EQ(replay({file, "--from", "20", "--to", "40"}), 0) << errors;
    EXPECT_THAT(out, HasSubstr("replayed 40 ticks"));
    EXPECT_EQ(replay({file, "--from", "20", "--to", "40", "--out", part}), 0) << errors;
    EXPECT_THAT(out, HasSubstr("21 ticks, up to tick 40"));
    EXPECT_EQ(replay({part}), 1);
    EXPECT_THAT(errors, HasSubstr("begins with tick 20"));
    EXPECT_EQ(replay({file, "--from", "1000000", "--out", part}), 1);
    EXPECT_THAT(errors, HasSubstr("holds no tick of that span"));
}

TEST_F(Recorded, RunsAreReplayedUpToADamageThatIsNamed) {
    const std::string file = record();
    std::string bytes = read(file);
    bytes[bytes.size() / 2] = static_cast<char>(bytes[bytes.size() / 2] ^ 1);
    std::ofstream(file, std::ios::binary) << bytes;
    EXPECT_EQ(replay({file}), 1);
    EXPECT_GT(number_after(out, "replayed "), 5) << out << errors;
    EXPECT_THAT(errors, HasSubstr("does not match its checksum (byte "));
    EXPECT_THAT(errors, HasSubstr("the last whole tick is "));
}

TEST_F(Recorded, PlayGoesOnWhenTheDiskIsFullAndTheReportIsWritten) {
    const std::string small = scratch_folder() + "/small";
    fs::create_directories(small);
    if (::mount("none", small.c_str(), "tmpfs", 0, "size=360k") != 0) {
        GTEST_SKIP() << "only root may mount a small file system";
    }
    {
        const std::string report = small + "/server.json";
        const auto server = start_server({"--set",
                                          "recording.file=\"" + small + "/run.zrec\"",
                                          "--set",
                                          "recording.ring_s=0",
                                          "--report",
                                          report});
        Child client("client-sim", play(20, 12));
        EXPECT_TRUE(server->wait_for_errors("No space left on device", kPatience))
            << server->errors();
        EXPECT_EQ(client.wait(0.0), -1) << "it is told while play goes on";
        EXPECT_EQ(client.wait(kPatience), 0) << client.output();
        server->signal(SIGTERM);
        EXPECT_EQ(server->wait(kPatience), 3) << "what was asked for is not there";
        const std::string text = read(report);
        EXPECT_THAT(text, HasSubstr("\"state_hash\""));
        EXPECT_EQ(number_after(text, "\"recording_failures\": "), 1) << text;
        EXPECT_EQ(replay({small + "/run.zrec"}), 1);
        EXPECT_THAT(out, HasSubstr("every hash agrees")) << errors;
    }
    EXPECT_EQ(::umount(small.c_str()), 0);
}

}  // namespace
}  // namespace zoned::testing_process
