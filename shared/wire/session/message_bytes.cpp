#include "shared/wire/session/message_bytes.h"

namespace zoned::wire {

namespace {

constexpr int kMostVarintBytes = 10;
/// Tags and lengths are numbers of 32 bits.
constexpr int kMostShortBytes = 5;

}  // namespace

void MessageWriter::tag(std::uint32_t number, WireType type) {
    varint(number << 3U | static_cast<std::uint32_t>(type));
}

void MessageWriter::varint(std::uint64_t value) {
    for (; value >= 0x80; value >>= 7U) {
        out_.push_back(static_cast<std::uint8_t>(value | 0x80U));
    }
    out_.push_back(static_cast<std::uint8_t>(value));
}

void MessageWriter::fixed32(std::uint32_t value) {
    for (int shift = 0; shift < 32; shift += 8) {
        out_.push_back(static_cast<std::uint8_t>(value >> shift));
    }
}

void MessageWriter::fixed64(std::uint64_t value) {
    fixed32(static_cast<std::uint32_t>(value));
    fixed32(static_cast<std::uint32_t>(value >> 32U));
}

void MessageWriter::text(std::string_view bytes) {
    varint(bytes.size());
    out_.insert(out_.end(), bytes.begin(), bytes.end());
}

void MessageWriter::end(std::size_t begun) {
    std::vector<std::uint8_t> length;
    MessageWriter(length).varint(out_.size() - begun);
    out_.insert(out_.begin() + static_cast<std::ptrdiff_t>(begun), length.begin(), length.end());
}

void MessageReader::fail() {
    ok_ = false;
    rest_ = {};
}

std::span<const std::uint8_t> MessageReader::take(std::size_t bytes) {
    if (bytes > rest_.size()) {
        fail();
        return {};
    }
    const auto taken = rest_.first(bytes);
    rest_ = rest_.subspan(bytes);
    return taken;
}

std::uint64_t MessageReader::varint_of(int most_bytes) {
    std::uint64_t value = 0;
    for (int i = 0; i < most_bytes && !rest_.empty(); ++i) {
        const std::uint8_t byte = rest_.front();
        rest_ = rest_.subspan(1);
        value |= static_cast<std::uint64_t>(byte & 0x7FU) << (7 * i);
        if (byte < 0x80) {
            return value;
        }
    }
    fail();
    return 0;
}

std::uint64_t MessageReader::varint() {
    return varint_of(kMostVarintBytes);
}

MessageTag MessageReader::tag() {
    const auto value = static_cast<std::uint32_t>(varint_of(kMostShortBytes));
    const MessageTag tag{value >> 3U, static_cast<WireType>(value & 7U)};
    if (tag.number == 0 || tag.type > WireType::kFixed32) {
        fail();
        return {};
    }
    return tag;
}

std::uint32_t MessageReader::fixed32() {
    const auto bytes = take(4);
    std::uint32_t value = 0;
    for (std::size_t i = bytes.size(); i-- > 0;) {
        value = value << 8U | bytes[i];
    }
    return value;
}

std::uint64_t MessageReader::fixed64() {
    const std::uint64_t low = fixed32();
    return low | static_cast<std::uint64_t>(fixed32()) << 32U;
}

std::span<const std::uint8_t> MessageReader::delimited() {
    return take(varint_of(kMostShortBytes));
}

void MessageReader::skip(MessageTag tag, int deepest) {
    switch (tag.type) {
        case WireType::kVarint:
            varint();
            break;
        case WireType::kFixed64:
            fixed64();
            break;
        case WireType::kDelimited:
            delimited();
            break;
        case WireType::kGroup:
            skip_group(tag.number, deepest - 1);
            break;
        case WireType::kFixed32:
            fixed32();
            break;
        default:
            fail();  // the end of a group that did not begin
    }
}

void MessageReader::skip_group(std::uint32_t number, int deepest) {
    while (deepest >= 0 && !done()) {
        const MessageTag inner = tag();
        if (inner.type == WireType::kGroupEnd && inner.number == number) {
            return;
        }
        skip(inner, deepest);
    }
    fail();
}

}  // namespace zoned::wire
