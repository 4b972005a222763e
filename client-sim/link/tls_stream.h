// TlsStream: one TLS 1.3 connection that carries frames (4-byte little-endian length, then one
// message).
#pragma once

#include "client-sim/link/frame_stream.h"

#include <cstdint>
#include <string>
#include <vector>

namespace zoned::link {

class TlsStream final : public SocketStream {
  public:
    TlsStream(asio::io_context& io, asio::ssl::context& tls, Trust trust, StreamEvents events);

    void send_frame(const Bytes& frame) override;

  private:
    void on_open() override;
    std::span<std::uint8_t> room() override;
    void on_bytes(std::size_t size) override;
    [[nodiscard]] bool export_key(const char* label, wire::SealKey& key);

    std::vector<std::uint8_t> input_;
    std::size_t input_used_ = 0;
};

}  // namespace zoned::link
