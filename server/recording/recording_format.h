// Recording format: what a recording holds, its versions, and how a frame of the file is framed.
#pragma once

#include "server/mailbox/messages.h"
#include "shared/core/ids.h"

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace zoned::recording {

/// Version of the simulation. Raise it with every change after which the same input gives other
/// hashes.
inline constexpr std::uint32_t kSimulationGeneration = 32;
/// Version of the file format, part of the file's first eight bytes.
inline constexpr std::uint32_t kRecordingFormat = 3;

/// The header of a recording: the run that it comes from.
struct RecordingHeader {
    std::uint32_t generation = kSimulationGeneration;
    std::string program;   ///< version of the program, for messages
    std::string target;    ///< processor target of the build, for information
    std::string compiler;  ///< for information
    std::string config_text;
    std::string config_digest;
    std::uint64_t seed = 0;

    /// Program, target, compiler and generation of this build.
    static RecordingHeader of_this_build();
};

/// The whole state of a world after a tick, as app::World::save writes it: where a recording begins
/// that was switched on while the world ran.
struct RecordedState {
    Tick tick = 0;
    std::vector<std::uint8_t> bytes;
};

/// A tick: what the world was given before it, and the hash of each zone after it.
struct TickRecord {
    Tick tick = 0;
    std::vector<mailbox::InboxItem> items;  ///< in the order in which they came
    /// By zone, the first is zone 1. Empty where the server stopped within the tick.
    std::vector<std::uint64_t> hashes;
};

/// A file is 8 bytes of magic and then frames: a head of 32 bytes, and as many bytes of payload as
/// it says. The payload is a message of proto/recording.proto, by kind.
enum class FrameKind : std::uint32_t {
    kHeader = 1,
    kInputs = 2,
    kHashes = 3,
    kEnd = 4,
    kState =
        5,  ///< after the header, where the first tick is not tick 1; no message, but the bytes
};

inline constexpr std::size_t kMagicBytes = 8;
inline constexpr std::size_t kFrameHeadBytes = 32;
/// A damaged length must not make the reader ask for all memory.
inline constexpr std::uint64_t kMaxPayloadBytes = 1ULL << 28U;

struct FrameHead {
    FrameKind kind = FrameKind::kHeader;
    std::uint32_t length = 0;  ///< of the payload, bytes
    Tick tick = 0;             ///< of inputs, hashes and state; 0 for the others
    std::uint64_t checksum = 0;
};

using MagicBytes = std::array<char, kMagicBytes>;
using FrameHeadBytes = std::array<unsigned char, kFrameHeadBytes>;

/// The magic of a format of this family.
MagicBytes magic_of(std::uint32_t format);
/// The format that a magic names; none: it is no recording.
std::optional<std::uint32_t> format_of(const MagicBytes& magic);

/// Finds every damage that one read error makes, and all others but for one in 2^64. It does not
/// resist forgery.
std::uint64_t checksum_of(std::string_view payload);

/// Little endian: length, kind, tick, checksum of the payload, checksum of the head.
FrameHeadBytes encode_head(const FrameHead& head);
/// None: the head's own checksum does not match.
std::optional<FrameHead> decode_head(const FrameHeadBytes& bytes);

}  // namespace zoned::recording
