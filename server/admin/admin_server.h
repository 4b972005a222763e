// AdminServer: HTTP on a thread of its own; bytes become requests for the router, replies become
// bytes.
#pragma once

#include "server/admin/admin_router.h"
#include "server/admin/spectator/spectator_sample.h"

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

namespace zoned::admin {

/// Limits of a server that faces a hostile network; what exceeds them is refused and counted.
struct AdminSettings {
    std::string address = "127.0.0.1";  ///< numeric; any but loopback takes a certificate
    std::string certificate_file;       ///< PEM chain; empty: no TLS
    std::string key_file;               ///< PEM
    std::uint16_t port = 0;             ///< 0: any free one
    std::string token;
    std::size_t max_connections = 128;  ///< with more, the one that waited longest is closed
    std::size_t max_header_bytes = 8192;
    std::size_t max_body_bytes = 65536;
    double request_timeout_s = 10.0;  ///< until the next request is complete
    double write_timeout_s = 10.0;    ///< until the client has taken an answer
    double answer_timeout_s = 30.0;   ///< until the process has answered
    double requests_per_s = 200.0;    ///< of one connection; twice as many at once
    /// Of all connections together; twice as many at once. Each costs a hash and a lookup at least.
    double total_requests_per_s = 2000.0;
    double accepts_per_s = 2000.0;  ///< more wait in the kernel's queue
};

/// Figures of the server itself; read them on its thread.
struct AdminStats {
    std::uint64_t accepted = 0;
    std::uint64_t bytes_out = 0;  ///< bodies
    std::size_t connections = 0;
    std::size_t viewers = 0;
    std::map<unsigned, std::uint64_t> answers;  ///< by status
};

/// The simulation and its network never wait for this thread. Routes are called on it, and may
/// reply from any thread.
class AdminServer {
  public:
    /// Binds and listens; throws std::system_error or std::invalid_argument with a text for the
    /// operator.
    /// With a source, viewers look at the world on /api/v1/spectate (a WebSocket; the token is its
    /// second protocol, after "zoned").
    AdminServer(AdminSettings settings,
                std::vector<AdminRoute> routes,
                SpectatorSource source = {});
    ~AdminServer();
    AdminServer(const AdminServer&) = delete;
    AdminServer& operator=(const AdminServer&) = delete;

    void start();
    /// Closes all connections; returns when the thread has ended.
    void stop();

    /// Runs `work` on the server's thread; from any thread.
    void post(std::function<void()> work);

    [[nodiscard]] std::uint16_t port() const;

    /// On the server's thread only.
    [[nodiscard]] const AdminStats& stats() const;
    [[nodiscard]] const AdminRouter& router() const;

  private:
    struct Impl;
    std::unique_ptr<Impl> impl_;
};

}  // namespace zoned::admin
