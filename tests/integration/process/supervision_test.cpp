// Those who look after a server: systemd by its socket, Agones by a stand-in for its sidecar,
// players behind a router.
#include "tests/integration/process/admin_fixture.h"

#include <gmock/gmock.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <atomic>
#include <chrono>
#include <csignal>
#include <cstdlib>
#include <functional>
#include <mutex>
#include <thread>

namespace zoned::testing_process {
namespace {

using testing::HasSubstr;

/// A variable of the environment of children, for a while.
class Variable {
  public:
    Variable(const char* name, const std::string& value) : name_(name) {
        ::setenv(name, value.c_str(), 1);
    }

    Variable(const Variable&) = delete;
    Variable& operator=(const Variable&) = delete;

    ~Variable() { ::unsetenv(name_); }

  private:
    const char* name_;
};

/// A thread that runs until the end of the test.
class Loop {
  public:
    explicit Loop(std::function<void()> turn)
        : thread_([this, turn = std::move(turn)] {
              while (!stop_) {
                  turn();
              }
          }) {}

    Loop(const Loop&) = delete;
    Loop& operator=(const Loop&) = delete;

    ~Loop() {
        stop_ = true;
        thread_.join();
    }

  private:
    std::atomic<bool> stop_{false};
    std::thread thread_;
};

bool readable(int fd) {
    pollfd waits{fd, POLLIN, 0};
    return ::poll(&waits, 1, 50) > 0;
}

/// A socket on a free port of loopback.
int bound_socket(int type, std::uint16_t& port) {
    const int fd = ::socket(AF_INET, type | SOCK_CLOEXEC, 0);
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    address.sin_port = htons(port);
    const int yes = 1;
    ::setsockopt(fd, SOL_SOCKET, SO_REUSEADDR, &yes, sizeof(yes));
    EXPECT_EQ(::bind(fd, reinterpret_cast<sockaddr*>(&address), sizeof(address)), 0);
    socklen_t size = sizeof(address);
    ::getsockname(fd, reinterpret_cast<sockaddr*>(&address), &size);
    port = ntohs(address.sin_port);
    return fd;
}

/// Lines that several threads add to.
class Lines {
  public:
    void add(const std::string& line) {
        const std::lock_guard lock(mutex_);
        text_ += line + "\n";
    }

    [[nodiscard]] std::string text() const {
        const std::lock_guard lock(mutex_);
        return text_;
    }

    [[nodiscard]] std::size_t count(const std::string& line) const {
        std::istringstream in(text());
        std::size_t n = 0;
        for (std::string each; std::getline(in, each);) {
            n += each == line ? 1 : 0;
        }
        return n;
    }

    bool wait_for(const std::string& line, std::size_t times = 1) const {
        for (int i = 0; i < 600 && count(line) < times; ++i) {
            std::this_thread::sleep_for(std::chrono::milliseconds(50));
        }
        return count(line) >= times;
    }

  private:
    mutable std::mutex mutex_;
    std::string text_;
};

class Supervised : public Admin {};

TEST_F(Supervised, SystemdHearsThatTheServerIsReadyLivesAndStops) {
    const std::string path = scratch_folder() + "/notify";
    const int fd = ::socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC, 0);
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    ASSERT_LT(path.size(), sizeof(address.sun_path));
    path.copy(address.sun_path, path.size());
    ASSERT_EQ(::bind(fd, reinterpret_cast<sockaddr*>(&address), sizeof(address)), 0);
    Lines heard;
    {
        const Loop listener([&] {
            char bytes[4096];
            const ssize_t n = readable(fd) ? ::recv(fd, bytes, sizeof(bytes), 0) : 0;
            if (n > 0) {
                heard.add(std::string(bytes, static_cast<std::size_t>(n)));
            }
        });
        const Variable socket("NOTIFY_SOCKET", path);
        const Variable watchdog("WATCHDOG_USEC", "400000");
        serve();
        EXPECT_TRUE(heard.wait_for("READY=1")) << heard.text();
        EXPECT_TRUE(heard.wait_for("WATCHDOG=1", 3)) << heard.text();
        ASSERT_EQ(status_of(order("/api/v1/pace", R"({"scale": 0})")), 200);
        EXPECT_TRUE(heard.wait_for("WATCHDOG=1", heard.count("WATCHDOG=1") + 5))
            << "a world that a developer has paused is alive";
        EXPECT_THAT(heard.text(), HasSubstr("STATUS=ready tcp="));
        server->signal(SIGTERM);
        EXPECT_EQ(server->wait(kPatience), 0);
        EXPECT_TRUE(heard.wait_for("STOPPING=1")) << heard.text();
    }
    ::close(fd);
}

/// A router: passes datagrams between players and the server, whose own port players cannot guess.
class Router {
  public:
    Router()
        : inside_(bound_socket(SOCK_DGRAM, inside_port_)),
          outside_(bound_socket(SOCK_DGRAM, port_)) {}

    Router(const Router&) = delete;
    Router& operator=(const Router&) = delete;

    ~Router() {
        loop_.reset();
        ::close(inside_);
        ::close(outside_);
    }

    void pass_to(int server_port) {
        server_ = static_cast<std::uint16_t>(server_port);
        loop_ = std::make_unique<Loop>([this] { turn(); });
    }

    [[nodiscard]] std::uint16_t port() const { return port_; }

    [[nodiscard]] int passed() const { return passed_; }

  private:
    /// One player at a time: the last that sent hears the answers.
    void turn() {
        char bytes[2048];
        sockaddr_in from{};
        socklen_t size = sizeof(from);
        if (readable(outside_)) {
            const ssize_t n = ::recvfrom(
                outside_, bytes, sizeof(bytes), 0, reinterpret_cast<sockaddr*>(&from), &size);
            player_ = from;
            sockaddr_in to{};
            to.sin_family = AF_INET;
            to.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
            to.sin_port = htons(server_);
            passed_ += ::sendto(inside_,
                                bytes,
                                static_cast<std::size_t>(n),
                                0,
                                reinterpret_cast<sockaddr*>(&to),
                                sizeof(to)) == n;
        }
        for (;;) {
            const ssize_t n = ::recv(inside_, bytes, sizeof(bytes), MSG_DONTWAIT);
            if (n <= 0) {
                return;
            }
            ::sendto(outside_,
                     bytes,
                     static_cast<std::size_t>(n),
                     0,
                     reinterpret_cast<sockaddr*>(&player_),
                     sizeof(player_));
        }
    }

    std::uint16_t inside_port_ = 0;
    std::uint16_t port_ = 0;
    std::uint16_t server_ = 0;
    int inside_;
    int outside_;
    sockaddr_in player_{};
    std::atomic<int> passed_{0};
    std::unique_ptr<Loop> loop_;
};

TEST_F(Supervised, PlayersSendWhereTheServerIsAdvertised) {
    Router router;
    server = start_server({"--set",
                           "network.advertise.address=\"play.example.org\"",
                           "--set",
                           "network.advertise.tcp_port=30001",
                           "--set",
                           "network.advertise.udp_port=" + std::to_string(router.port())});
    EXPECT_THAT(server->output(),
                HasSubstr("zones=1 address=play.example.org public_tcp=30001 public_udp=" +
                          std::to_string(router.port()) + "\n"));
    router.pass_to(number_after(server->output(), " udp="));
    Child client("client-sim", play(1, 3));
    EXPECT_EQ(client.wait(kPatience), 0) << client.output();
    EXPECT_GT(router.passed(), 30) << "datagrams came through the router";
    server->signal(SIGTERM);
    EXPECT_EQ(server->wait(kPatience), 0);
}

/// What a game server sees of Agones: the sidecar's HTTP interface as its documentation describes
/// it (https://agones.dev/site/docs/guides/client-sdks/rest/).
class Sidecar {
  public:
    Sidecar() : fd_(bound_socket(SOCK_STREAM, port_)) {}

    Sidecar(const Sidecar&) = delete;
    Sidecar& operator=(const Sidecar&) = delete;

    ~Sidecar() {
        loop_.reset();
        ::close(fd_);
    }

    /// Nobody is answered before.
    void start(int udp_port) {
        udp_port_ = udp_port;
        ::listen(fd_, 8);
        loop_ = std::make_unique<Loop>([this] {
            if (readable(fd_)) {
                const int client = ::accept(fd_, nullptr, nullptr);
                answer(client);
                ::close(client);
            }
        });
    }

    [[nodiscard]] std::uint16_t port() const { return port_; }

    [[nodiscard]] const Lines& asked() const { return asked_; }

  private:
    void answer(int client) {
        std::string request;
        char bytes[4096];
        while (request.find("\r\n\r\n") == std::string::npos) {
            const ssize_t n = ::recv(client, bytes, sizeof(bytes), 0);
            if (n <= 0) {
                return;
            }
            request.append(bytes, static_cast<std::size_t>(n));
        }
        const std::string line = request.substr(0, request.find(" HTTP"));
        asked_.add(line);
        std::string body = "{}";
        std::string status = "200 OK";
        if (line == "GET /gameserver") {
            body =
                "{\"object_meta\":{\"name\":\"local\"},\"status\":{\"state\":\"Scheduled\","
                "\"address\":\"203.0.113.9\",\"ports\":[{\"name\":\"tcp\",\"port\":7001},"
                "{\"name\":\"udp\",\"port\":" +
                std::to_string(udp_port_) + "}]}}";
        } else if (line != "POST /ready" && line != "POST /health" && line != "POST /shutdown") {
            status = "404 Not Found";
        }
        // In two chunks, as Go's server does with long bodies.
        const std::string head = body.substr(0, 1);
        const std::string tail = body.substr(1);
        std::ostringstream out;
        out << "HTTP/1.1 " << status
            << "\r\nContent-Type: application/json\r\nTransfer-Encoding: chunked\r\n\r\n"
            << std::hex << head.size() << "\r\n"
            << head << "\r\n"
            << tail.size() << "\r\n"
            << tail << "\r\n0\r\n\r\n";
        const std::string text = out.str();
        ::send(client, text.data(), text.size(), MSG_NOSIGNAL);
    }

    std::uint16_t port_ = 0;
    int fd_;
    int udp_port_ = 0;
    Lines asked_;
    std::unique_ptr<Loop> loop_;
};

TEST_F(Supervised, AgonesHearsThatTheServerIsReadyLivesAndEnds) {
    Sidecar sidecar;
    Router router;
    const Variable port("AGONES_SDK_HTTP_PORT", std::to_string(sidecar.port()));
    std::thread late([&] {  // the sidecar may start after the server
        std::this_thread::sleep_for(std::chrono::milliseconds(1500));
        sidecar.start(router.port());
    });
    server = start_server(
        {"--set", "network.agones.enabled=true", "--set", "network.agones.health_every_s=0.2"});
    late.join();
    EXPECT_THAT(server->output(),
                HasSubstr(" address=203.0.113.9 public_tcp=7001 public_udp=" +
                          std::to_string(router.port()) + "\n"));
    EXPECT_TRUE(sidecar.asked().wait_for("POST /ready"));
    EXPECT_TRUE(sidecar.asked().wait_for("POST /health", 3));
    EXPECT_EQ(sidecar.asked().count("POST /ready"), 1U);
    EXPECT_EQ(sidecar.asked().count("POST /shutdown"), 0U);
    router.pass_to(number_after(server->output(), " udp="));
    Child client("client-sim", play(1, 2));
    EXPECT_EQ(client.wait(kPatience), 0) << client.output();
    server->signal(SIGTERM);
    EXPECT_EQ(server->wait(kPatience), 0) << server->errors();
    EXPECT_TRUE(sidecar.asked().wait_for("POST /shutdown"));
}

TEST_F(Supervised, AMissingSidecarIsNamed) {
    const Variable port("AGONES_SDK_HTTP_PORT", "1");
    Child lonely("zoned",
                 {"serve",
                  "--config",
                  minimal(),
                  "--set",
                  state_set(),
                  "--set",
                  "network.agones.enabled=true",
                  "--set",
                  "network.agones.patience_s=0.6"});
    EXPECT_EQ(lonely.wait(kPatience), 3);
    EXPECT_THAT(lonely.errors(), HasSubstr("the sidecar at port 1 does not say"));
}

}  // namespace
}  // namespace zoned::testing_process
