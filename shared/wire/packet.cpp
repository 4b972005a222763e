#include "shared/wire/packet.h"

#include "shared/wire/bit_stream.h"
#include "shared/wire/byte_order.h"

#include <bit>
#include <cmath>

namespace zoned::wire {
namespace {

// First byte of the own state.
constexpr std::uint8_t kOwnInputMissing = 1u << 0;
constexpr std::uint8_t kOwnGrounded = 1u << 1;
constexpr std::uint8_t kOwnCarried = 1u << 2;
constexpr std::size_t kOwnFixedBytes = 1 + 1 + 2 + 6 * 4;  // flags, lead, yaw, six floats

void append_bytes(std::size_t count, std::vector<std::uint8_t>& out) {
    out.resize(out.size() + count);
}

void write_own(const OwnState& own, Tick packet_tick, std::vector<std::uint8_t>& out) {
    append_leb128(own.avatar.value, out);
    append_leb128(static_cast<std::uint32_t>(packet_tick - own.input_tick), out);
    const std::size_t at = out.size();
    append_bytes(kOwnFixedBytes, out);
    std::uint8_t* p = out.data() + at;
    p[0] = static_cast<std::uint8_t>((own.input_missing ? kOwnInputMissing : 0) |
                                     (own.state.grounded ? kOwnGrounded : 0) |
                                     (own.state.carried ? kOwnCarried : 0));
    p[1] = static_cast<std::uint8_t>(own.input_lead);
    store_le<std::uint16_t>(own.state.yaw, p + 2);
    for (int i = 0; i < 3; ++i) {
        store_le(std::bit_cast<std::uint32_t>(own.state.position[i]), p + 4 + 4 * i);
        store_le(std::bit_cast<std::uint32_t>(own.state.velocity[i]), p + 16 + 4 * i);
    }
}

constexpr std::uint8_t kIncomplete = 1u << 6;

std::uint8_t widened_byte(const Widened& widened) {
    return static_cast<std::uint8_t>(widened.step | (widened.incomplete ? kIncomplete : 0));
}

bool read_widened(std::span<const std::uint8_t> body, std::size_t& offset, Widened& widened) {
    if (offset >= body.size()) {
        return false;
    }
    const std::uint8_t byte = body[offset++];
    widened.step = byte & (kIncomplete - 1);
    widened.incomplete = (byte & kIncomplete) != 0;
    return byte < 2 * kIncomplete && (widened.step <= kMostWidening || widened.step == kNoBound);
}

bool read_own(std::span<const std::uint8_t> body,
              std::size_t& offset,
              Tick packet_tick,
              OwnState& own) {
    std::uint32_t avatar = 0;
    std::uint32_t age = 0;
    if (!read_leb128(body, offset, avatar) || avatar == 0 || !read_leb128(body, offset, age) ||
        static_cast<Tick>(age) > packet_tick || body.size() - offset < kOwnFixedBytes) {
        return false;
    }
    const std::uint8_t* p = body.data() + offset;
    offset += kOwnFixedBytes;
    if ((p[0] & ~(kOwnInputMissing | kOwnGrounded | kOwnCarried)) != 0) {
        return false;
    }
    own.avatar = EntityId(avatar);
    own.input_tick = packet_tick - age;
    own.input_missing = (p[0] & kOwnInputMissing) != 0;
    own.state.grounded = (p[0] & kOwnGrounded) != 0;
    own.state.carried = (p[0] & kOwnCarried) != 0;
    own.input_lead = static_cast<std::int8_t>(p[1]);
    own.state.yaw = load_le<std::uint16_t>(p + 2);
    bool finite = true;
    for (int i = 0; i < 3; ++i) {
        own.state.position[i] = std::bit_cast<float>(load_le<std::uint32_t>(p + 4 + 4 * i));
        own.state.velocity[i] = std::bit_cast<float>(load_le<std::uint32_t>(p + 16 + 4 * i));
        finite =
            finite && std::isfinite(own.state.position[i]) && std::isfinite(own.state.velocity[i]);
    }
    return finite;
}

}  // namespace

void write_datagram_header(const DatagramHeader& header, std::uint8_t* out6) {
    store_le(header.connection, out6);
    store_le(header.sequence_low, out6 + 4);
}

core::Result<DatagramHeader> read_datagram_header(std::span<const std::uint8_t> datagram) {
    using Header = core::Result<DatagramHeader>;
    if (datagram.size() < kDatagramHeaderBytes + kSealTagBytes) {
        return Header::failure("datagram too short");
    }
    if (datagram.size() > kMaxDatagramBytes) {
        return Header::failure("datagram too long");
    }
    return DatagramHeader{load_le<std::uint32_t>(datagram.data()),
                          load_le<std::uint16_t>(datagram.data() + 4)};
}

std::uint64_t expand_sequence(std::uint16_t low, std::uint64_t expected) {
    constexpr std::uint64_t kWindow = 1u << 16;
    constexpr std::uint64_t kHalf = kWindow / 2;
    const std::uint64_t candidate = (expected & ~(kWindow - 1)) | low;
    if (candidate + kHalf <= expected) {
        return candidate + kWindow;
    }
    if (candidate > expected + kHalf && candidate >= kWindow) {
        return candidate - kWindow;
    }
    return candidate;
}

void write_transport(const DownTransport& t, std::uint8_t* out12) {
    store_le(t.send_time_us, out12);
    store_le(t.ack_low, out12 + 4);
    store_le(t.ack_bits, out12 + 6);
    store_le(t.ack_delay_10us, out12 + 10);
}

void write_transport(const UpTransport& t, std::uint8_t* out10) {
    store_le(t.ack_low, out10);
    store_le(t.ack_bits, out10 + 2);
    store_le(t.ack_delay_10us, out10 + 6);
    store_le(t.one_way_128us, out10 + 8);
}

core::Result<DownTransport> read_down_transport(std::span<const std::uint8_t> plain) {
    if (plain.size() < kDownTransportBytes) {
        return core::Result<DownTransport>::failure("transport header cut off");
    }
    return DownTransport{load_le<std::uint32_t>(plain.data()),
                         load_le<std::uint16_t>(plain.data() + 4),
                         load_le<std::uint32_t>(plain.data() + 6),
                         load_le<std::uint16_t>(plain.data() + 10)};
}

core::Result<UpTransport> read_up_transport(std::span<const std::uint8_t> plain) {
    if (plain.size() < kUpTransportBytes) {
        return core::Result<UpTransport>::failure("transport header cut off");
    }
    return UpTransport{load_le<std::uint16_t>(plain.data()),
                       load_le<std::uint32_t>(plain.data() + 2),
                       load_le<std::uint16_t>(plain.data() + 6),
                       load_le<std::uint16_t>(plain.data() + 8)};
}

bool AckTracker::on_received(std::uint64_t sequence) {
    if (sequence == 0) {
        return false;
    }
    if (sequence > newest_) {
        const std::uint64_t ahead = sequence - newest_;
        // The old newest becomes bit ahead - 1; before the first packet there is none.
        const std::uint64_t history =
            (static_cast<std::uint64_t>(bits_) << 1) | (newest_ != 0 ? 1u : 0u);
        bits_ = ahead > 32 ? 0u : static_cast<std::uint32_t>(history << (ahead - 1));
        newest_ = sequence;
        return true;
    }
    const std::uint64_t behind = newest_ - sequence;
    if (behind == 0 || behind > 32) {
        return false;
    }
    const std::uint32_t bit = 1u << (behind - 1);
    const bool duplicate = (bits_ & bit) != 0;
    bits_ |= bit;
    return !duplicate;
}

namespace {

std::uint32_t zone_and_flags(const DownHead& head) {
    return (static_cast<std::uint32_t>(head.zone.value) << 3) | (head.coded ? 4u : 0u) |
           (head.has_widened ? 2u : 0u) | (head.has_own ? 1u : 0u);
}

}  // namespace

void write_down_head(const DownHead& head, std::vector<std::uint8_t>& out) {
    const std::size_t at = out.size();
    append_bytes(4, out);
    store_le(static_cast<std::uint32_t>(head.tick), out.data() + at);
    append_leb128(zone_and_flags(head), out);
    if (head.has_widened) {
        out.push_back(widened_byte(head.widened));
    }
    if (head.has_own) {
        write_own(head.own, head.tick, out);
    }
}

std::size_t down_head_bytes(const DownHead& head) {
    std::size_t bytes = 5 + (head.has_widened ? 1 : 0);
    for (std::uint32_t rest = zone_and_flags(head); rest >= 0x80; rest >>= 7) {
        ++bytes;
    }
    return bytes;
}

void rewrite_widened(const Widened& widened, std::vector<std::uint8_t>& body) {
    std::size_t at = 4;
    while ((body[at] & 0x80U) != 0) {
        ++at;
    }
    body[at + 1] = widened_byte(widened);
}

core::Result<ParsedDownHead> read_down_head(std::span<const std::uint8_t> body) {
    using Head = core::Result<ParsedDownHead>;
    if (body.size() < 4) {
        return Head::failure("state head cut off");
    }
    ParsedDownHead parsed;
    parsed.head.tick = load_le<std::uint32_t>(body.data());
    parsed.records_offset = 4;
    std::uint32_t zone_and_own = 0;
    if (!read_leb128(body, parsed.records_offset, zone_and_own) || zone_and_own > 0x7FFFF) {
        return Head::failure("malformed zone in a state head");
    }
    parsed.head.zone = ZoneId(static_cast<std::uint16_t>(zone_and_own >> 3));
    parsed.head.has_own = (zone_and_own & 1) != 0;
    parsed.head.has_widened = (zone_and_own & 2) != 0;
    parsed.head.coded = (zone_and_own & 4) != 0;
    if (parsed.head.has_widened &&
        !read_widened(body, parsed.records_offset, parsed.head.widened)) {
        return Head::failure("malformed bounds in a state head");
    }
    if (parsed.head.has_own &&
        !read_own(body, parsed.records_offset, parsed.head.tick, parsed.head.own)) {
        return Head::failure("malformed own state");
    }
    return parsed;
}

}  // namespace zoned::wire
