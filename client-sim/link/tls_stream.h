// TlsStream: one TLS 1.3 connection that carries frames (4-byte little-endian length, then one
// message).
#pragma once

// clang-format off
#include <coroutine>  // before asio, which clang++ needs to find its coroutines
#include <asio.hpp>
#include <asio/ssl.hpp>
// clang-format on

#include "client-sim/link/link.h"

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

namespace zoned::link {

/// How a client makes sure that it talks to the right server.
struct Trust {
    enum class TrustKind : std::uint8_t {
        kPin,       ///< the certificate's SHA-256 must be `pin`
        kInsecure,  ///< anyone; for development on loopback addresses
        kVerify,    ///< chain and host name against the certificate authorities
    } kind = TrustKind::kVerify;
    std::vector<std::uint8_t> pin;  ///< 32 bytes
    std::string host;               ///< name to verify and to send as server name
};

/// Callbacks of a stream. Nothing is called after close().
struct StreamEvents {
    std::function<void(const wire::SealKey& down, const wire::SealKey& up)> opened;
    std::function<void(Bytes frame)> frame;
    std::function<void(std::string reason)> closed;
};

class TlsStream : public std::enable_shared_from_this<TlsStream> {
  public:
    /// Larger frames from the server are refused; a world description fits many times over.
    static constexpr std::size_t kMaxFrameBytes = 16u << 20;

    TlsStream(asio::io_context& io, asio::ssl::context& tls, Trust trust, StreamEvents events);

    void connect(const asio::ip::tcp::endpoint& endpoint);
    void send_frame(const Bytes& frame);
    /// Sends all queued frames, says goodbye, closes. No event follows.
    void close();

    /// The server's address once connected.
    [[nodiscard]] const asio::ip::address& peer() const { return peer_; }

  private:
    void handshake();
    void on_open();
    [[nodiscard]] std::string check_pin();
    [[nodiscard]] bool export_key(const char* label, wire::SealKey& key);
    void read();
    bool take_frames();
    void write();
    void finish();
    void fail(const std::string& reason);

    asio::ssl::stream<asio::ip::tcp::socket> stream_;
    Trust trust_;
    StreamEvents events_;
    asio::ip::address peer_;
    std::vector<std::uint8_t> input_;
    std::size_t input_used_ = 0;
    std::vector<std::uint8_t> pending_;
    std::vector<std::uint8_t> writing_;
    bool open_ = false;
    bool closing_ = false;
    bool dead_ = false;
};

}  // namespace zoned::link
