// Recovery: a server that is killed amid play goes on, and its clients with it.
#include "tests/integration/process/fixture.h"

#include <csignal>
#include <filesystem>
#include <string>
#include <thread>
#include <vector>

namespace zoned::testing_process {
namespace {

class Recovering : public Process {
  protected:
    void SetUp() override { std::filesystem::remove_all(scratch_folder() + "/journal"); }

    /// A server that starts again when it dies, at the ports of one that has ended.
    std::unique_ptr<Child> start_again_and_again(std::vector<std::string> more = {}) {
        auto first = start_server({"--set", "network.admin=false"});
        const std::string tcp = std::to_string(tcp_port);
        first->signal(SIGTERM);
        EXPECT_EQ(first->wait(kPatience), 0) << first->errors();
        more.insert(more.end(),
                    {"--restart",
                     "--set",
                     "network.admin=false",
                     "--set",
                     "network.tcp_port=" + tcp,
                     "--set",
                     "network.udp_port=" + tcp,
                     "--set",
                     "recovery.on=true",
                     "--set",
                     "recovery.snapshot_every_s=2"});
        return start_server(more);
    }

    /// The newest child of a process; 0: it has none.
    static pid_t child_of(pid_t parent) {
        const std::string name = std::to_string(parent);
        std::ifstream file("/proc/" + name + "/task/" + name + "/children");
        pid_t child = 0;
        for (pid_t next = 0; file >> next;) {
            child = next;
        }
        return child;
    }

    /// Kills the server, and waits until another one is there in its place.
    static bool kill_child_of(Child& restarter) {
        const pid_t victim = child_of(restarter.pid());
        if (victim == 0 || ::kill(victim, SIGKILL) != 0) {
            return false;
        }
        while (restarter.wait(0.01) == -1) {
            const pid_t now = child_of(restarter.pid());
            if (now != 0 && now != victim) {
                return true;
            }
        }
        return false;
    }

    static std::size_t count_of(const std::string& text, const std::string& word) {
        std::size_t count = 0;
        for (std::size_t at = text.find(word); at != std::string::npos;
             at = text.find(word, at + 1)) {
            ++count;
        }
        return count;
    }
};

TEST_F(Recovering, BotsPlayOnWhereAServerIsKilledThrice) {
    const std::string recording = scratch_folder() + "/run.zrec";
    const auto server = start_again_and_again({"--set", "recording.file=\"" + recording + "\""});
    const std::string report = scratch_folder() + "/client.json";
    std::vector<std::string> arguments = play(20, 16);
    arguments.insert(arguments.end(), {"--report", report, "--behaviour", "wander,chat"});
    Child bots("client-sim", arguments);
    for (int deaths = 0; deaths < 3; ++deaths) {
        std::this_thread::sleep_for(std::chrono::milliseconds(3100 + 370 * deaths));
        ASSERT_TRUE(kill_child_of(*server)) << server->errors();
    }
    EXPECT_EQ(bots.wait(kPatience), 0) << bots.output() << bots.errors() << server->errors();
    const std::string said = read(report);
    EXPECT_EQ(number_after(said, "\"recovered\":"), 60) << "each bot came back each time";
    EXPECT_EQ(number_after(said, "\"sessions_lost\":"), 0);
    EXPECT_GT(number_after(said, "\"events_delivered\":"), 0);
    server->signal(SIGTERM);
    EXPECT_EQ(server->wait(kPatience), 0) << server->errors();
    EXPECT_EQ(count_of(server->errors(), "the world goes on after tick"), 3U) << server->errors();
    EXPECT_EQ(count_of(server->errors(), "not all is as it was"), 0U)
        << "every hash is that of the server before: " << server->errors();
    EXPECT_EQ(count_of(server->errors(), "died of signal 9"), 3U);
    EXPECT_FALSE(std::filesystem::exists(scratch_folder() + "/journal"))
        << "after a stop in good order the world begins anew";
    // Each server has recorded its own part, from the state that it was given.
    int recordings = 0;
    for (const auto& entry : std::filesystem::directory_iterator(scratch_folder())) {
        if (entry.path().extension() == ".zrec") {
            ++recordings;
            Child replay("zoned", {"replay", entry.path()});
            EXPECT_NE(replay.wait(kPatience), -1);
            EXPECT_NE(replay.output().find("every hash agrees"), std::string::npos)
                << entry.path() << replay.errors();
        }
    }
    EXPECT_EQ(recordings, 4) << server->errors();
}

TEST_F(Recovering, WhatCannotStartIsNotStartedAgain) {
    Child wrong("zoned", {"serve", "--restart", "--config", minimal(), "--set", "no.such.field=1"});
    EXPECT_EQ(wrong.wait(kPatience), 2);
    EXPECT_EQ(wrong.errors().find("started again"), std::string::npos) << wrong.errors();
}

TEST_F(Recovering, AServerThatKeepsDyingIsGivenUp) {
    const auto server = start_again_and_again();
    int deaths = 0;
    while (deaths < 30 && kill_child_of(*server)) {
        ++deaths;
    }
    EXPECT_EQ(server->wait(kPatience), 1) << server->errors();
    EXPECT_EQ(deaths, 10);
    EXPECT_NE(server->errors().find("it is given up"), std::string::npos) << server->errors();
}

}  // namespace
}  // namespace zoned::testing_process
