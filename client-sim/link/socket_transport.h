// SocketTransport: a client's Transport over real sockets; SocketNetwork owns the parts that all
// clients share.
#pragma once

#include "client-sim/link/frame_stream.h"
#include "client-sim/link/link.h"
#include "client-sim/link/sockets/name_lookup.h"
#include "client-sim/link/sockets/sockets.h"

#include <cstdint>
#include <memory>
#include <string>
#include <unordered_map>
#include <vector>

namespace zoned::link {

struct NetworkSettings {
    std::string host;
    std::string port;
    Trust trust;
    std::string ca_file;  ///< for Trust::kVerify; empty: the system's authorities
    int udp_sockets = 16;
    MakeStream make_stream = make_tls_stream;
};

class SocketTransport;

/// One per process and thread. Drive it: poll(now), then advance the clients, then flush().
class SocketNetwork {
  public:
    /// By sockets of the system. Looks the host up, and waits for that. trouble() says what went
    /// wrong.
    explicit SocketNetwork(NetworkSettings settings);
    /// By these sockets. Never waits.
    SocketNetwork(NetworkSettings settings, std::unique_ptr<Sockets> sockets);
    ~SocketNetwork();

    /// Why there can be no session, in one clear line; empty: all is well.
    [[nodiscard]] const std::string& trouble() const { return trouble_; }

    [[nodiscard]] std::unique_ptr<SocketTransport> make_transport();

    /// Delivers what has arrived.
    void poll(double now_s);
    /// Hands queued datagrams to the kernel.
    void flush();

    /// True when the resolved address is this machine.
    [[nodiscard]] bool loopback() const { return address_.is_loopback(); }

    /// Bytes of IP and UDP headers per datagram.
    [[nodiscard]] int header_bytes() const { return address_.is_v4() ? 28 : 48; }

    [[nodiscard]] std::uint64_t send_drops() const { return sockets_->send_drops(); }

  private:
    friend class SocketTransport;

    /// A stream that says its last words.
    struct LeavingStream {
        std::shared_ptr<FrameStream> stream;
        double until_s = 0.0;
    };

    void on_datagram(std::span<const std::uint8_t> datagram);
    void close(std::shared_ptr<FrameStream> stream);

    NetworkSettings settings_;
    std::unique_ptr<Sockets> sockets_;
    std::string trouble_;
    TlsContext tls_;
    std::uint16_t port_ = 0;
    SocketAddress address_;  // of the host, where it was looked up at once
    std::vector<SocketTransport*> transports_;
    std::unordered_map<std::uint32_t, SocketTransport*> by_connection_;
    std::vector<LeavingStream> leaving_;
    std::uint64_t made_ = 0;
    double now_s_ = 0.0;
};

class SocketTransport final : public Transport {
  public:
    SocketTransport(SocketNetwork& network, std::uint64_t index);
    ~SocketTransport() override;

    void set_events(TransportEvents events) override;
    void open() override;
    void send_frame(Bytes frame) override;
    void set_udp(std::uint16_t udp_port, std::uint32_t connection_id) override;
    void send_datagram(Bytes datagram) override;
    void close() override;
    void prepare(const std::string& host,
                 std::uint16_t port,
                 const std::string& certificate_sha256) override;

    [[nodiscard]] bool prepared() const override { return route_ && route_->is_open; }

    bool redirect(const std::string& host,
                  std::uint16_t port,
                  const std::string& certificate_sha256) override;

  private:
    friend class SocketNetwork;

    /// A server, and the stream that leads to it.
    struct ServerRoute {
        std::string host;
        std::uint16_t port = 0;
        std::string certificate;
        Trust trust;
        std::shared_ptr<FrameStream> stream;
        bool is_used = false;    // not just prepared
        bool is_open = false;    // and its client has not heard of it
        bool is_inside = false;  // it protects what it carries
    };

    [[nodiscard]] std::shared_ptr<ServerRoute> route_to(
        const std::string& host,
        std::uint16_t port,
        const std::string& certificate_sha256) const;
    /// Makes its stream and connects.
    void start(ServerRoute& route);
    /// The route holds its stream, so the stream's events must not hold the route.
    [[nodiscard]] StreamEvents events_of(ServerRoute* to);
    void lose(ServerRoute& route, std::string reason);
    void report_open();
    /// Whether a prepared stream leads to that server; no host: that of the present one.
    [[nodiscard]] bool leads_ahead(const std::string& host,
                                   std::uint16_t port,
                                   const std::string& certificate_sha256) const;
    void drop_ahead();
    void advance();

    SocketNetwork& network_;
    std::size_t index_;
    TransportEvents events_;
    std::shared_ptr<ServerRoute> route_;  // open() goes there
    std::shared_ptr<ServerRoute> ahead_;  // prepared; null: nothing is
    std::uint32_t connection_ = 0;
};

}  // namespace zoned::link
