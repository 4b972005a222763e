// A recording that is shown: any tick of it is the world as it was, whichever way it is reached.
#include "tests/integration/process/fixture.h"
#include "tests/unit/admin/raw_socket.h"

#include <chrono>
#include <csignal>
#include <functional>
#include <thread>

namespace zoned::testing_process {
namespace {

using testing_admin::status_of;

class Replayed : public Process {
  protected:
    /// A recording of some seconds with bots, shown by a server of its own.
    void show() {
        file = scratch_folder() + "/run.zrec";
        {
            const auto server = start_server({"--set", "recording.file=\"" + file + "\""});
            Child client("client-sim", play(3, 4));
            EXPECT_EQ(client.wait(kPatience), 0) << client.output();
            server->signal(SIGTERM);
            EXPECT_EQ(server->wait(kPatience), 0) << server->errors();
        }
        replay =
            std::make_unique<Child>("zoned", std::vector<std::string>{"replay", file, "--serve"});
        ASSERT_TRUE(replay->wait_for_output("#token=", kPatience)) << replay->errors();
        const std::string said = replay->output();
        port = static_cast<std::uint16_t>(number_after(said, "admin="));
        last = number_after(said, "ticks=");
        token = said.substr(said.find("#token=") + 7, 64);
    }

    [[nodiscard]] std::string bearer() const { return "Authorization: Bearer " + token + "\r\n"; }

    [[nodiscard]] std::string ask(const std::string& target) const {
        return testing_admin::get(port, target, bearer());
    }

    [[nodiscard]] std::string order(const std::string& target, const std::string& body) const {
        return testing_admin::send_raw(
            port,
            "POST " + target + " HTTP/1.1\r\nHost: 127.0.0.1\r\nConnection: close\r\n" + bearer() +
                "Content-Type: application/json\r\nContent-Length: " + std::to_string(body.size()) +
                "\r\n\r\n" + body);
    }

    bool wait_until(const std::function<bool()>& good) const {
        for (int i = 0; i < 600; ++i) {
            if (good()) {
                return true;
            }
            std::this_thread::sleep_for(std::chrono::milliseconds(50));
        }
        return false;
    }

    [[nodiscard]] int tick() const { return number_after(ask("/api/v1/replay"), "\"tick\":"); }

    void seek(int to) {
        EXPECT_EQ(status_of(order("/api/v1/replay", "{\"tick\": " + std::to_string(to) + "}")),
                  200);
        EXPECT_TRUE(wait_until([&] {
            const std::string state = ask("/api/v1/replay");
            return number_after(state, "\"tick\":") == to &&
                   number_after(state, "\"target\":") == 0;
        })) << ask("/api/v1/replay");
    }

    /// An entity as the page is told of it.
    [[nodiscard]] std::string entity(int id) const {
        const std::string answer = ask("/api/v1/inspect/" + std::to_string(id));
        return answer.substr(answer.find("\r\n\r\n"));
    }

    std::string file;
    std::string token;
    std::unique_ptr<Child> replay;
    std::uint16_t port = 0;
    int last = 0;
};

TEST_F(Replayed, IsShownAtAnyTickAndPace) {
    show();
    ASSERT_GT(last, 60);
    EXPECT_EQ(status_of(testing_admin::get(port, "/api/v1/replay")), 401);
    EXPECT_EQ(status_of(ask("/")), 200);
    EXPECT_TRUE(wait_until([&] { return tick() > 5; })) << "it plays by itself";
    EXPECT_EQ(status_of(order("/api/v1/pace", "{\"scale\": 0}")), 200);
    seek(60);
    const std::string there = entity(12);
    EXPECT_NE(there.find("wanderer"), std::string::npos) << there;
    EXPECT_EQ(status_of(order("/api/v1/pace", "{\"steps\": 3}")), 200);
    EXPECT_TRUE(wait_until([&] { return tick() == 63; }));
    EXPECT_NE(entity(12), there) << "its tick at least";
    seek(last);
    seek(20);
    EXPECT_NE(entity(12), there);
    seek(60);
    EXPECT_EQ(entity(12), there) << "the same world, whichever way it was reached";
    EXPECT_EQ(status_of(order("/api/v1/replay", "{\"tick\": 0}")), 400);
    EXPECT_EQ(status_of(order("/api/v1/replay", "{\"tick\": 4000000}")), 400);
    EXPECT_EQ(status_of(ask("/api/v1/charts")), 200);
    EXPECT_NE(ask("/api/v1/replay").find("\"fault\": \"\""), std::string::npos)
        << ask("/api/v1/replay");
    replay->signal(SIGTERM);
    EXPECT_EQ(replay->wait(kPatience), 0) << replay->errors();
}

TEST_F(Replayed, SaysWhatCannotBeShown) {
    file = scratch_folder() + "/run.zrec";
    {
        const auto server = start_server({"--set", "recording.file=\"" + file + "\""});
        EXPECT_EQ(server->wait(2.0), -1);
        server->signal(SIGTERM);
        EXPECT_EQ(server->wait(kPatience), 0) << server->errors();
    }
    const std::string part = scratch_folder() + "/part.zrec";
    Child cut("zoned", {"replay", file, "--from", "10", "--out", part});
    EXPECT_EQ(cut.wait(kPatience), 0) << cut.errors();
    Child late("zoned", {"replay", part, "--serve"});
    EXPECT_EQ(late.wait(kPatience), 1);
    EXPECT_NE(late.errors().find("begins with tick 10"), std::string::npos) << late.errors();
    Child both("zoned", {"replay", file, "--serve", "--info"});
    EXPECT_EQ(both.wait(kPatience), 2);
}

}  // namespace
}  // namespace zoned::testing_process
