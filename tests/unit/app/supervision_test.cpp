// Supervision: signs of life stop when the world stands still; Agones' answers are read or refused.
#include "server/app/supervision/supervision.h"

#include <gmock/gmock.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <chrono>
#include <cstdlib>

namespace zoned::app {
namespace {

/// An abstract socket that stands in for systemd's.
class NotifySocket {
  public:
    NotifySocket() : fd_(::socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0)) {
        name_ = "@zoned_test_" + std::to_string(::getpid());
        sockaddr_un address{};
        address.sun_family = AF_UNIX;
        name_.copy(address.sun_path, name_.size());
        address.sun_path[0] = '\0';
        const auto size = static_cast<socklen_t>(offsetof(sockaddr_un, sun_path) + name_.size());
        EXPECT_EQ(::bind(fd_, reinterpret_cast<sockaddr*>(&address), size), 0);
        ::setenv("NOTIFY_SOCKET", name_.c_str(), 1);
        ::setenv("WATCHDOG_USEC", "100000", 1);
    }

    NotifySocket(const NotifySocket&) = delete;
    NotifySocket& operator=(const NotifySocket&) = delete;

    ~NotifySocket() {
        ::close(fd_);
        ::unsetenv("NOTIFY_SOCKET");
        ::unsetenv("WATCHDOG_USEC");
        ::unsetenv("WATCHDOG_PID");
    }

    /// What came since the last call.
    std::vector<std::string> heard() {
        std::vector<std::string> messages;
        char bytes[1024];
        for (;;) {
            const ssize_t n = ::recv(fd_, bytes, sizeof(bytes), 0);
            if (n <= 0) {
                return messages;
            }
            messages.emplace_back(bytes, static_cast<std::size_t>(n));
        }
    }

  private:
    int fd_;
    std::string name_;
};

TEST(Supervision, GivesSignsOfLifeOnlyWhileTheWorldTicks) {
    NotifySocket systemd;
    asio::io_context io;
    std::uint64_t ticks = 1;
    bool moves = true;
    Supervision supervision(io, config::ServerSettings{}, [&] { return moves ? ++ticks : ticks; });
    EXPECT_EQ(std::getenv("NOTIFY_SOCKET"), nullptr) << "children do not speak for us";
    supervision.ready("ready tcp=1");
    EXPECT_THAT(systemd.heard(), testing::ElementsAre("READY=1\nSTATUS=ready tcp=1", "WATCHDOG=1"));
    io.run_for(std::chrono::milliseconds(400));
    EXPECT_GE(systemd.heard().size(), 3U);
    moves = false;
    io.run_for(std::chrono::milliseconds(200));
    systemd.heard();
    io.run_for(std::chrono::milliseconds(300));
    EXPECT_THAT(systemd.heard(), testing::IsEmpty()) << "systemd restarts what is silent";
    moves = true;
    io.run_for(std::chrono::milliseconds(300));
    EXPECT_THAT(systemd.heard(), testing::Contains("WATCHDOG=1"));
    supervision.stopping("asked to stop");
    EXPECT_THAT(systemd.heard(), testing::Contains("STOPPING=1\nSTATUS=stopping: asked to stop"));
    supervision.stopped();
    io.run();
}

TEST(Supervision, IsSilentWhereNobodyAsks) {
    asio::io_context io;
    Supervision supervision(io, config::ServerSettings{}, [] { return 1U; });
    supervision.ready("ready");
    io.run_for(std::chrono::milliseconds(50));
    supervision.stopped();
    io.run();
    EXPECT_EQ(supervision.find_address(), config::AdvertiseSettings{});
}

TEST(ServiceNotice, HeedsAWatchdogThatIsForThisProcess) {
    {
        const NotifySocket systemd;
        ::setenv("WATCHDOG_PID", "1", 1);
        EXPECT_FALSE(ServiceNotice().watchdog_s()) << "of another process";
    }
    const NotifySocket systemd;
    ::setenv("WATCHDOG_PID", std::to_string(::getpid()).c_str(), 1);
    ::setenv("WATCHDOG_USEC", "250000", 1);
    EXPECT_DOUBLE_EQ(ServiceNotice().watchdog_s().value_or(0.0), 0.25);
}

TEST(Agones, SaysWherePlayersReachTheServer) {
    const auto address = parse_game_server(
        R"({"object_meta":{"name":"x"},"status":{"state":"Ready","address":"192.0.2.7",)"
        R"("ports":[{"name":"udp","port":7200},{"name":"tcp","port":7100},{"name":"odd"}]}})",
        "tcp",
        "udp");
    ASSERT_TRUE(address.ok()) << address.error();
    EXPECT_EQ(address->address, "192.0.2.7");
    EXPECT_EQ(address->tcp_port, 7100);
    EXPECT_EQ(address->udp_port, 7200);
    const auto other = parse_game_server(
        R"({"status":{"address":"a","ports":[{"name":"udp","port":70000},{"name":"x","port":5}]}})",
        "tcp",
        "udp");
    ASSERT_TRUE(other.ok());
    EXPECT_EQ(other->tcp_port, 0);
    EXPECT_EQ(other->udp_port, 0) << "no port there is";
}

TEST(Agones, IsRefusedWhereItDoesNotSay) {
    for (const char* text : {"",
                             "[]",
                             "no",
                             "{}",
                             R"({"status":{}})",
                             R"({"status":{"address":""}})",
                             R"({"status":7})"}) {
        EXPECT_FALSE(parse_game_server(text, "tcp", "udp").ok()) << text;
    }
}

}  // namespace
}  // namespace zoned::app
