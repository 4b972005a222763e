// SocketTransport: a client's Transport over real sockets; SocketNetwork owns the parts that all
// clients share.
#pragma once

#include "client-sim/link/conditioner.h"
#include "client-sim/link/frame_stream.h"
#include "client-sim/link/link.h"
#include "client-sim/link/name_lookup.h"
#include "client-sim/link/udp_pool.h"

#include <cstdint>
#include <memory>
#include <optional>
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
    ConditionerSettings conditioner;
    /// Address of the host where it is known already; else the network looks it up.
    std::optional<asio::ip::tcp::endpoint> endpoint = {};
    MakeStream make_stream = {};  ///< none: by TLS (TlsStream)
};

class SocketTransport;

/// One per process and thread. Drive it: poll(now), then advance the clients, then flush().
class SocketNetwork {
  public:
    /// Resolves the host where its address is not given. Throws std::runtime_error with one clear
    /// line when that fails.
    explicit SocketNetwork(NetworkSettings settings);
    ~SocketNetwork();

    [[nodiscard]] std::unique_ptr<SocketTransport> make_transport();

    /// Delivers what has arrived (and what the conditioner held back until now).
    void poll(double now_s);
    /// Hands queued datagrams to the kernel.
    void flush();

    /// True when the resolved address is this machine.
    [[nodiscard]] bool loopback() const { return endpoint_.address().is_loopback(); }

    /// Bytes of IP and UDP headers per datagram.
    [[nodiscard]] int header_bytes() const { return endpoint_.address().is_v4() ? 28 : 48; }

    /// Traffic of the bottlenecks of all connected clients in one direction, until the last poll.
    [[nodiscard]] std::vector<BottleneckMeter> bottlenecks(Direction direction) const;

    [[nodiscard]] std::uint64_t send_drops() const { return udp_->send_drops(); }

  private:
    friend class SocketTransport;

    void on_datagram(std::span<const std::uint8_t> datagram);

    NetworkSettings settings_;
    asio::io_context io_{1};
    asio::ssl::context tls_;
    asio::ip::tcp::endpoint endpoint_;
    std::unique_ptr<UdpPool> udp_;
    std::vector<SocketTransport*> transports_;
    std::unordered_map<std::uint32_t, SocketTransport*> by_connection_;
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
        std::string host;  // of a redirect; empty: that of the server before
        std::uint16_t port = 0;
        std::string certificate;
        Trust trust;
        asio::ip::tcp::endpoint endpoint;
        std::unique_ptr<NameLookup> lookup;  // none: the endpoint is known
        std::shared_ptr<FrameStream> stream;
        bool waits = false;    // for the lookup
        bool is_used = false;  // not just prepared
        bool is_open = false;  // and its client has not heard of it
        wire::SealKey down{};  // of an open stream ...
        wire::SealKey up{};
        bool is_inside = false;  // ... or it protects what it carries
    };

    [[nodiscard]] std::shared_ptr<ServerRoute> route_to(
        const std::string& host,
        std::uint16_t port,
        const std::string& certificate_sha256) const;
    /// Makes its stream and connects, when its name is known.
    void start(std::shared_ptr<ServerRoute> route);
    /// The route holds its stream, so the stream's events must not hold the route.
    [[nodiscard]] StreamEvents events_of(ServerRoute* to);
    void connect(ServerRoute& route);
    void lose(ServerRoute& route, std::string reason);
    void report_open();
    [[nodiscard]] static bool leads_to(const ServerRoute& route,
                                       const std::string& host,
                                       std::uint16_t port,
                                       const std::string& certificate_sha256);
    void drop_ahead();
    void advance();

    /// Delivers the messages that the conditioner releases at `now_s`, both directions.
    void release(double now_s);
    void transmit(Bytes datagram);

    SocketNetwork& network_;
    std::size_t index_;
    TransportEvents events_;
    std::shared_ptr<ServerRoute> route_;  // open() goes there
    std::shared_ptr<ServerRoute> ahead_;  // prepared; null: nothing is
    std::uint32_t connection_ = 0;
    sockaddr_storage to_{};
    socklen_t to_size_ = 0;
    bool conditioned_;
    Conditioner up_datagrams_;
    Conditioner down_datagrams_;
    Conditioner up_frames_;
    Conditioner down_frames_;
};

}  // namespace zoned::link
