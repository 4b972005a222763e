#include "shared/wire/websocket/websocket_frames.h"

#include <algorithm>

namespace zoned::wire {

namespace {

constexpr std::uint8_t kFinal = 0x80;
constexpr std::uint8_t kReservedBits = 0x70;
constexpr std::uint8_t kMasked = 0x80;
/// Lengths of 7 bits; these two say that 16 or 64 bits follow.
constexpr std::uint8_t kTwoBytes = 126;
constexpr std::uint8_t kEightBytes = 127;
constexpr std::size_t kMaskBytes = 4;
/// A buffer that grew beyond this for once is given back.
constexpr std::size_t kKeptBuffer = 16384;

bool is_control(WebSocketOpcode opcode) {
    return static_cast<std::uint8_t>(opcode) >= 8;
}

std::size_t length_bytes(std::uint8_t second) {
    const auto form = static_cast<std::uint8_t>(second & ~kMasked);
    return form == kTwoBytes ? 2 : form == kEightBytes ? 8 : 0;
}

}  // namespace

std::string_view text_of(WebSocketFault fault) {
    switch (fault) {
        case WebSocketFault::kNone:
            break;
        case WebSocketFault::kReserved:
            return "a frame has a reserved bit or an unknown opcode";
        case WebSocketFault::kMask:
            return "a frame is masked where it must not be, or is not where it must";
        case WebSocketFault::kControl:
            return "a control frame comes in parts or is longer than 125 bytes";
        case WebSocketFault::kLength:
            return "a frame's length is not in its shortest form";
        case WebSocketFault::kOversize:
            return "a message is too long";
        case WebSocketFault::kFragments:
            return "a message's parts make no sense, or are too many";
        case WebSocketFault::kText:
            return "a text message came; the protocol has binary ones alone";
    }
    return "nothing is wrong";
}

std::uint16_t close_code_of(WebSocketFault fault) {
    constexpr std::uint16_t kProtocolError = 1002;
    constexpr std::uint16_t kUnsupported = 1003;
    constexpr std::uint16_t kTooBig = 1009;
    return fault == WebSocketFault::kOversize ? kTooBig
           : fault == WebSocketFault::kText   ? kUnsupported
                                              : kProtocolError;
}

WebSocketReader::WebSocketReader(WebSocketEnd end, std::size_t max_message_bytes)
    : end_(end),
      max_message_bytes_(max_message_bytes) {
}

bool WebSocketReader::fail(WebSocketFault fault) {
    fault_ = fault;
    return false;
}

bool WebSocketReader::next(std::span<const std::uint8_t>& bytes, WebSocketItem& item) {
    if (taken_) {
        taken_ = false;
        message_.clear();
        if (message_.capacity() > kKeptBuffer) {
            message_ = std::vector<std::uint8_t>();
        }
    }
    while (fault_ == WebSocketFault::kNone) {
        if (!in_payload_ && !take_head(bytes)) {
            return false;
        }
        take_payload(bytes);
        if (left_ > 0) {
            return false;
        }
        in_payload_ = false;
        head_size_ = 0;
        if (finish_frame(item)) {
            return true;
        }
    }
    return false;
}

/// True once the head is whole and makes sense.
bool WebSocketReader::take_head(std::span<const std::uint8_t>& bytes) {
    for (;;) {
        const std::size_t wanted =
            head_size_ < 2 ? 2
                           : 2 + length_bytes(head_[1]) +
                                 ((head_[1] & kMasked) != 0 ? kMaskBytes : std::size_t{0});
        if (head_size_ == wanted) {
            return read_head();
        }
        if (bytes.empty()) {
            return false;
        }
        const std::size_t count = std::min(wanted - head_size_, bytes.size());
        std::copy_n(bytes.begin(), count, head_.begin() + static_cast<std::ptrdiff_t>(head_size_));
        head_size_ += count;
        bytes = bytes.subspan(count);
    }
}

bool WebSocketReader::read_head() {
    const std::uint8_t code = head_[0] & 0x0F;
    if ((head_[0] & kReservedBits) != 0 || (code > 2 && code < 8) || code > 10) {
        return fail(WebSocketFault::kReserved);
    }
    opcode_ = static_cast<WebSocketOpcode>(code);
    last_ = (head_[0] & kFinal) != 0;
    const bool masked = (head_[1] & kMasked) != 0;
    if (masked != (end_ == WebSocketEnd::kServer)) {
        return fail(WebSocketFault::kMask);
    }
    const std::size_t wide = length_bytes(head_[1]);
    std::uint64_t length = head_[1] & ~kMasked;
    if (wide > 0) {
        length = 0;
        for (std::size_t i = 0; i < wide; ++i) {
            length = length << 8U | head_[2 + i];
        }
        if (length < (wide == 2 ? std::uint64_t{kTwoBytes} : std::uint64_t{65536}) ||
            (length >> 63U) != 0) {
            return fail(WebSocketFault::kLength);
        }
    }
    mask_ = {};
    if (masked) {
        std::copy_n(
            head_.begin() + static_cast<std::ptrdiff_t>(2 + wide), kMaskBytes, mask_.begin());
    }
    return begin_frame(length);
}

bool WebSocketReader::begin_frame(std::uint64_t length) {
    if (is_control(opcode_)) {
        if (!last_ || length > kMaxWebSocketControl) {
            return fail(WebSocketFault::kControl);
        }
        control_.clear();
    } else {
        if (opcode_ == WebSocketOpcode::kText) {
            return fail(WebSocketFault::kText);
        }
        if ((opcode_ == WebSocketOpcode::kContinuation) != (fragments_ > 0) ||
            fragments_ >= kMostFragments) {
            return fail(WebSocketFault::kFragments);
        }
        if (length > max_message_bytes_ - message_.size()) {
            announced_ = length + message_.size();
            return fail(WebSocketFault::kOversize);
        }
        ++fragments_;
    }
    left_ = length;
    mask_at_ = 0;
    in_payload_ = true;
    return true;
}

void WebSocketReader::take_payload(std::span<const std::uint8_t>& bytes) {
    const auto count = static_cast<std::size_t>(std::min<std::uint64_t>(left_, bytes.size()));
    std::vector<std::uint8_t>& into = is_control(opcode_) ? control_ : message_;
    const std::size_t before = into.size();
    into.insert(into.end(), bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(count));
    if (end_ == WebSocketEnd::kServer) {
        for (std::size_t i = 0; i < count; ++i) {
            into[before + i] = static_cast<std::uint8_t>(into[before + i] ^ mask_[mask_at_]);
            mask_at_ = (mask_at_ + 1) % kMaskBytes;
        }
    }
    bytes = bytes.subspan(count);
    left_ -= count;
}

/// True when an item is whole: a control frame, or the last part of a message.
bool WebSocketReader::finish_frame(WebSocketItem& item) {
    if (is_control(opcode_)) {
        item = {opcode_, control_};
        return true;
    }
    if (!last_) {
        return false;
    }
    fragments_ = 0;
    taken_ = true;
    item = {WebSocketOpcode::kBinary, message_};
    return true;
}

std::size_t write_websocket_head(WebSocketOpcode opcode,
                                 std::uint64_t length,
                                 std::array<std::uint8_t, kMaxWebSocketHead>& head) {
    head[0] = static_cast<std::uint8_t>(kFinal | static_cast<std::uint8_t>(opcode));
    const std::size_t wide = length < kTwoBytes ? 0 : length < 65536 ? 2 : 8;
    head[1] = wide == 0 ? static_cast<std::uint8_t>(length) : wide == 2 ? kTwoBytes : kEightBytes;
    for (std::size_t i = 0; i < wide; ++i) {
        head[2 + i] = static_cast<std::uint8_t>(length >> (8 * (wide - 1 - i)));
    }
    return 2 + wide;
}

void write_masked_frame(WebSocketOpcode opcode,
                        std::span<const std::uint8_t> payload,
                        std::uint32_t mask,
                        std::vector<std::uint8_t>& out) {
    std::array<std::uint8_t, kMaxWebSocketHead> head{};
    std::size_t size = write_websocket_head(opcode, payload.size(), head);
    head[1] |= kMasked;
    std::array<std::uint8_t, kMaskBytes> key{};
    for (std::size_t i = 0; i < kMaskBytes; ++i) {
        key[i] = static_cast<std::uint8_t>(mask >> (8 * i));
        head[size++] = key[i];
    }
    out.insert(out.end(), head.begin(), head.begin() + static_cast<std::ptrdiff_t>(size));
    for (std::size_t i = 0; i < payload.size(); ++i) {
        out.push_back(static_cast<std::uint8_t>(payload[i] ^ key[i % kMaskBytes]));
    }
}

}  // namespace zoned::wire
