// TlsListener: accepts streams of TLS, or WebSockets, within limits and names them by number;
// frames in and out.
#pragma once

#include "server/net/certificate.h"
#include "server/net/stream_connection.h"

#include <asio/io_context.hpp>

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>

namespace zoned::net {

struct TlsSettings {
    std::string bind_address = "::";  ///< numeric; "::" listens on all addresses of both families
    std::uint16_t port = 0;           ///< 0: any free one
    CertificateSettings certificate;
    ConnectionLimits limits;
    std::size_t max_connections = 25000;
    std::size_t max_connections_per_address = 64;  ///< IPv6: per /64 network. Not for loopback.
    double max_handshakes_per_s = 500.0;           ///< faster ones wait, network by network
    /// WebSockets in place of frames with length prefixes.
    std::optional<WebSocketGate> websocket = {};
    bool plain = false;             ///< no TLS: for WebSockets on a loopback address alone
    StreamNumber number_after = 0;  ///< streams get higher numbers than this
};

/// Events of streams, from the thread of the io_context, never from within a call of the listener.
struct TlsCallbacks {
    /// `spent_s`: how long the client took from its connection on, without its wait for a turn.
    std::function<void(StreamNumber, const Address& peer, bool loopback, double spent_s)> on_open;
    /// In its place for a WebSocket. `local`: the client is on this machine, as far as proxies say.
    std::function<void(StreamNumber, const Address& peer, bool local, double spent_s)>
        on_websocket = {};
    std::function<void(StreamNumber, std::span<const std::uint8_t> frame)> on_frame;
    /// Once per opened stream, by whichever side it ended. Empty reason: ended in order.
    std::function<void(StreamNumber, const std::string& reason)> on_closed;
};

/// Not thread-safe: driven by the thread of its io_context.
class TlsListener {
  public:
    /// Prepares the certificate and binds; throws std::system_error or std::runtime_error with a
    /// text for the operator. Nothing is accepted before start().
    TlsListener(asio::io_context& io, const TlsSettings& settings, TlsCallbacks callbacks);
    ~TlsListener();
    TlsListener(const TlsListener&) = delete;
    TlsListener& operator=(const TlsListener&) = delete;

    void start();
    /// Accepts no more; open streams go on.
    void stop_accepting();
    /// Ends all streams at once, without callbacks. Called by the destructor too.
    void abort_all();

    /// Queues a frame; nothing happens when the stream is gone or closing.
    void send(StreamNumber stream, std::span<const std::uint8_t> frame, SharedBytes tail = nullptr);
    /// Ends a stream after its queue is sent.
    void close(StreamNumber stream);
    /// Bytes that wait to be sent; 0 when the stream is gone.
    [[nodiscard]] std::size_t backlog(StreamNumber stream) const;

    [[nodiscard]] std::uint16_t port() const;
    /// Sites whose pages may open WebSockets, from now on.
    void set_origins(std::vector<std::string> origins);
    /// SHA-256 of the certificate, hexadecimal; clients pin it. Empty without TLS.
    [[nodiscard]] const std::string& fingerprint() const;
    [[nodiscard]] const CertificateFiles& certificate_files() const;
    /// Streams that are not gone yet, those before or in their handshake or closing included.
    [[nodiscard]] std::size_t connections() const;
    [[nodiscard]] const TlsStats& stats() const;

  private:
    struct Impl;
    std::shared_ptr<Impl> impl_;  ///< shared with pending handlers
};

}  // namespace zoned::net
