// WebSocketFrames: messages in and out of the bytes of a WebSocket (RFC 6455), for either end.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>
#include <vector>

namespace zoned::wire {

/// Which end of the WebSocket reads: clients mask all that they send, servers nothing.
enum class WebSocketEnd : std::uint8_t {
    kServer,
    kClient,
};

/// Why the reader gives a WebSocket up.
enum class WebSocketFault : std::uint8_t {
    kNone,
    kReserved,   ///< a reserved bit or an unknown opcode
    kMask,       ///< a client's frame without a mask, or a server's with one
    kControl,    ///< a control frame in parts, or longer than 125 bytes
    kLength,     ///< a length in a wider form than it needs, or beyond 2^63
    kOversize,   ///< a message longer than the reader takes
    kFragments,  ///< a part without a beginning, a beginning within a message, or too many parts
    kText,       ///< a text message: the protocol has binary ones alone
};

/// For logs: what the peer did wrong.
[[nodiscard]] std::string_view text_of(WebSocketFault fault);

/// Status code of the Close frame that answers a fault (RFC 6455, section 7.4.1).
[[nodiscard]] std::uint16_t close_code_of(WebSocketFault fault);

enum class WebSocketOpcode : std::uint8_t {
    kContinuation = 0,
    kText = 1,
    kBinary = 2,
    kClose = 8,
    kPing = 9,
    kPong = 10,
};

/// Longest head of a frame, mask included.
inline constexpr std::size_t kMaxWebSocketHead = 14;
/// Longest payload of Close, Ping and Pong.
inline constexpr std::size_t kMaxWebSocketControl = 125;

/// The reader's find: a whole message, or a control frame.
struct WebSocketItem {
    WebSocketOpcode opcode = WebSocketOpcode::kBinary;  ///< kBinary, kClose, kPing or kPong
    std::span<const std::uint8_t> payload;              ///< until the next call
};

/// Reads the bytes of one direction, however they are cut. Memory grows with the bytes that came,
/// never with a length that was announced.
class WebSocketReader {
  public:
    /// A message may come in so many frames.
    static constexpr std::size_t kMostFragments = 64;

    WebSocketReader(WebSocketEnd end, std::size_t max_message_bytes);

    /// Takes bytes from the front of `bytes` until an item is whole: true, and `item` is filled.
    /// False: all bytes are taken, or fault() says why no more will be.
    bool next(std::span<const std::uint8_t>& bytes, WebSocketItem& item);

    [[nodiscard]] WebSocketFault fault() const { return fault_; }

    /// Length that was too much, where the fault is kOversize.
    [[nodiscard]] std::uint64_t announced() const { return announced_; }

  private:
    bool take_head(std::span<const std::uint8_t>& bytes);
    bool read_head();
    bool begin_frame(std::uint64_t length);
    void take_payload(std::span<const std::uint8_t>& bytes);
    bool finish_frame(WebSocketItem& item);
    bool fail(WebSocketFault fault);

    WebSocketEnd end_;
    std::size_t max_message_bytes_;
    WebSocketFault fault_ = WebSocketFault::kNone;
    std::uint64_t announced_ = 0;
    std::array<std::uint8_t, kMaxWebSocketHead> head_{};
    std::size_t head_size_ = 0;
    bool in_payload_ = false;
    WebSocketOpcode opcode_ = WebSocketOpcode::kBinary;  // of the frame that is being read
    bool last_ = false;                                  // of its message
    std::array<std::uint8_t, 4> mask_{};
    std::uint64_t left_ = 0;  // of its payload
    std::size_t mask_at_ = 0;
    std::size_t fragments_ = 0;  // of the message so far; 0: none has begun
    bool taken_ = false;         // the message was handed out by the last call
    std::vector<std::uint8_t> message_;
    std::vector<std::uint8_t> control_;
};

/// Head of an unmasked frame that is a whole message; returns its size.
std::size_t write_websocket_head(WebSocketOpcode opcode,
                                 std::uint64_t length,
                                 std::array<std::uint8_t, kMaxWebSocketHead>& head);

/// Appends a whole frame, masked as a client must.
void write_masked_frame(WebSocketOpcode opcode,
                        std::span<const std::uint8_t> payload,
                        std::uint32_t mask,
                        std::vector<std::uint8_t>& out);

}  // namespace zoned::wire
