// TlsStream: one TLS 1.3 connection that carries frames (4-byte little-endian length, then one
// message).
#pragma once

#include "client-sim/link/frame_stream.h"

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

namespace zoned::link {

class TlsStream final : public FrameStream, public std::enable_shared_from_this<TlsStream> {
  public:
    static constexpr std::size_t kMaxFrameBytes = kMostFrameBytes;

    TlsStream(asio::io_context& io, asio::ssl::context& tls, Trust trust, StreamEvents events);

    void connect(const asio::ip::tcp::endpoint& endpoint) override;
    void send_frame(const Bytes& frame) override;
    void close() override;

    /// The server's address once connected.
    [[nodiscard]] const asio::ip::address& peer() const { return peer_; }

  private:
    void handshake();
    void on_open();
    [[nodiscard]] bool export_key(const char* label, wire::SealKey& key);
    void read();
    bool take_frames();
    void write();
    void finish();
    void fail(const std::string& reason);

    TlsSocket stream_;
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
