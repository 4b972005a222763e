// NatsServer: a NATS server with JetStream of a test's own, from Debian's package, in a temporary
// folder.
#pragma once

#include <sys/types.h>

#include <cstdint>
#include <string>
#include <vector>

namespace zoned::test {

/// A port of this machine that nobody used a moment ago. Throws std::runtime_error.
[[nodiscard]] std::uint16_t free_port();

class NatsServer {
  public:
    /// Where the package is not installed, nothing else may be called.
    [[nodiscard]] static bool installed();

    /// Starts it on a free port. `options` are added to its command line. Throws
    /// std::runtime_error.
    explicit NatsServer(std::vector<std::string> options = {});
    ~NatsServer();
    NatsServer(const NatsServer&) = delete;
    NatsServer& operator=(const NatsServer&) = delete;

    [[nodiscard]] std::string url() const { return "nats://127.0.0.1:" + std::to_string(port_); }

    [[nodiscard]] std::uint16_t port() const { return port_; }

    [[nodiscard]] std::string log() const;

    /// By SIGKILL: what it had not written is gone.
    void kill();
    /// On the same port, with what it kept.
    void start();
    /// Stands still, connections and all, until go_on().
    void pause() const;
    void go_on() const;

  private:
    std::vector<std::string> options_;
    std::string folder_;
    std::uint16_t port_ = 0;
    pid_t process_ = 0;
};

}  // namespace zoned::test
