// Traffic: what the bytes of state packets were spent on: by entity type, by reason and by field.
#pragma once

#include "shared/core/ids.h"
#include "shared/core/json.h"
#include "shared/wire/field_table.h"

#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace zoned::wire {

/// Why bytes were sent. A sender knows all of these; a receiver can't tell heartbeats and what was
/// sent again after loss from news.
enum class TrafficReason : std::uint8_t {
    kUpdate,     ///< truth left the bound, came to rest, or looks otherwise
    kKeyframe,   ///< news, absolute, because a keyframe was due or the client held none
    kHeartbeat,  ///< nothing was wrong, but it was time
    kJoin,       ///< the first record of an entity for this client, or of this level of detail
    kResent,     ///< all copies were lost
    kRepeat,     ///< one more copy, because the network loses packets
    kRemoval,    ///< the entity left the client's view
    kOwnState,   ///< the client's own avatar
    kHead,       ///< of the packet: tick, zone, bounds
    kUnread,     ///< receivers only: could not be decoded
};

inline constexpr std::size_t kTrafficReasons = 10;
inline constexpr std::array<const char*, kTrafficReasons> kTrafficReasonNames{"news",
                                                                              "keyframe",
                                                                              "heartbeat",
                                                                              "join",
                                                                              "resent",
                                                                              "repeat",
                                                                              "removal",
                                                                              "own_state",
                                                                              "head",
                                                                              "unread"};

/// What bits are in: the fields of the table, then these.
inline constexpr std::size_t kRecordHeadPart = kFields.size();
inline constexpr std::size_t kPaddingPart = kFields.size() + 1;
inline constexpr std::size_t kRecordParts = kFields.size() + 2;
inline constexpr std::size_t kOwnStatePart = kRecordParts;
inline constexpr std::size_t kPacketHeadPart = kRecordParts + 1;
/// Of records coded for one client: what they build on, their end and what rounds it up to bytes.
inline constexpr std::size_t kCodeHeadPart = kRecordParts + 2;
inline constexpr std::size_t kTrafficParts = kRecordParts + 3;

[[nodiscard]] const char* traffic_part_name(std::size_t part);

/// Bits of one record, by part; their sum is eight times its bytes. Of a record that was coded with
/// others for one client, what it told beyond what had to be expected, as whole bits of the code.
using RecordBits = std::array<std::uint8_t, kRecordParts>;

/// Sums of bits. Whatever is not a record of an entity (removals name no type) is of no type.
class TrafficTable {
  public:
    using Row = std::array<std::array<std::uint64_t, kTrafficParts>, kTrafficReasons>;

    void add_record(TypeIndex type, TrafficReason reason, const RecordBits& bits);
    void add_removal(std::size_t bits);
    /// `own_bytes` of the `head_bytes` in all before the records are the own state.
    void add_packet(std::size_t head_bytes, std::size_t own_bytes);
    /// Of a packet's records that were coded for one client, what is none of theirs.
    void add_code_head(std::size_t bits);
    /// Records that nobody could read.
    void add_unread(std::size_t bytes);
    void add(const TrafficTable& other);

    /// Rows: 0 is what is of no type, 1 + i is type i. Types never met may be missing.
    [[nodiscard]] std::span<const Row> rows() const { return rows_; }

    [[nodiscard]] std::uint64_t packets() const { return packets_; }

    [[nodiscard]] std::uint64_t bits() const;
    [[nodiscard]] std::uint64_t bits(TrafficReason reason) const;
    [[nodiscard]] std::uint64_t bits_of_part(std::size_t part) const;
    [[nodiscard]] std::uint64_t bits_of_part(std::size_t row, std::size_t part) const;
    [[nodiscard]] std::uint64_t bits_of_row(std::size_t row) const;
    [[nodiscard]] std::uint64_t bits(std::size_t row, TrafficReason reason) const;

  private:
    Row& row(std::size_t index);

    std::vector<Row> rows_;
    std::uint64_t packets_ = 0;
};

/// Members of an object that is open: bytes (bits / 8) of bodies by type, each by reason and field,
/// and of all types together.
void write_traffic(core::JsonWriter& json,
                   const TrafficTable& table,
                   std::span<const std::string> types);

/// A table for people: a line per type with its share by reason, and a line per field, both in
/// descending order; bars are to scale. `types` are the names by type index, `overhead_bytes` what
/// travels with each packet beside its body (headers, seal).
[[nodiscard]] std::string traffic_text(const TrafficTable& table,
                                       std::span<const std::string> types,
                                       double seconds,
                                       std::size_t overhead_bytes);

}  // namespace zoned::wire
