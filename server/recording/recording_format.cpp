#include "server/recording/recording_format.h"

#include "shared/core/block_hash.h"

#include <algorithm>
#include <cstring>

namespace zoned::recording {

namespace {

/// The first format had no number in its magic.
constexpr MagicBytes kFirstMagic = {'Z', 'O', 'N', 'E', 'D', 'R', 'E', 'C'};
constexpr std::string_view kFamily = "ZREC";
constexpr std::size_t kDigits = kMagicBytes - kFamily.size();

void put(std::uint64_t value, std::size_t bytes, unsigned char* out) {
    for (std::size_t i = 0; i < bytes; ++i) {
        out[i] = static_cast<unsigned char>(value >> (8 * i));
    }
}

std::uint64_t get(const unsigned char* in, std::size_t bytes) {
    std::uint64_t value = 0;
    for (std::size_t i = 0; i < bytes; ++i) {
        value |= static_cast<std::uint64_t>(in[i]) << (8 * i);
    }
    return value;
}

constexpr std::size_t kHeadChecksumAt = kFrameHeadBytes - 8;

std::uint64_t head_checksum(const FrameHeadBytes& bytes) {
    return checksum_of({reinterpret_cast<const char*>(bytes.data()), kHeadChecksumAt});
}

}  // namespace

RecordingHeader RecordingHeader::of_this_build() {
    RecordingHeader header;
    header.program = ZONED_VERSION;
    header.target = ZONED_TARGET_NAME;
#if defined(__clang__)
    header.compiler = "clang++ " __clang_version__;
#else
    header.compiler = "g++ " __VERSION__;
#endif
    return header;
}

MagicBytes magic_of(std::uint32_t format) {
    MagicBytes magic{};
    std::copy(kFamily.begin(), kFamily.end(), magic.begin());
    for (std::size_t i = 0; i < kDigits; ++i) {
        magic[kMagicBytes - 1 - i] = static_cast<char>('0' + format % 10);
        format /= 10;
    }
    return magic;
}

std::optional<std::uint32_t> format_of(const MagicBytes& magic) {
    if (magic == kFirstMagic) {
        return 1;
    }
    if (!std::equal(kFamily.begin(), kFamily.end(), magic.begin())) {
        return std::nullopt;
    }
    std::uint32_t format = 0;
    for (std::size_t i = kFamily.size(); i < kMagicBytes; ++i) {
        if (magic[i] < '0' || magic[i] > '9') {
            return std::nullopt;
        }
        format = 10 * format + static_cast<std::uint32_t>(magic[i] - '0');
    }
    return format;
}

std::uint64_t checksum_of(std::string_view payload) {
    core::BlockHash hash;
    std::size_t at = 0;
    for (; at + 8 <= payload.size(); at += 8) {
        std::uint64_t word = 0;
        std::memcpy(&word, payload.data() + at, sizeof(word));
        hash.add(word);
    }
    std::uint64_t rest = 0;
    std::memcpy(&rest, payload.data() + at, payload.size() - at);
    hash.add(rest);
    hash.add(static_cast<std::uint64_t>(payload.size()));
    return hash.value();
}

FrameHeadBytes encode_head(const FrameHead& head) {
    FrameHeadBytes bytes{};
    put(head.length, 4, bytes.data());
    put(static_cast<std::uint32_t>(head.kind), 4, bytes.data() + 4);
    put(static_cast<std::uint64_t>(head.tick), 8, bytes.data() + 8);
    put(head.checksum, 8, bytes.data() + 16);
    put(head_checksum(bytes), 8, bytes.data() + kHeadChecksumAt);
    return bytes;
}

std::optional<FrameHead> decode_head(const FrameHeadBytes& bytes) {
    if (get(bytes.data() + kHeadChecksumAt, 8) != head_checksum(bytes)) {
        return std::nullopt;
    }
    FrameHead head;
    head.length = static_cast<std::uint32_t>(get(bytes.data(), 4));
    head.kind = static_cast<FrameKind>(get(bytes.data() + 4, 4));
    head.tick = static_cast<Tick>(get(bytes.data() + 8, 8));
    head.checksum = get(bytes.data() + 16, 8);
    return head;
}

}  // namespace zoned::recording
