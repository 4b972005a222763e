// Traffic: counts the bytes of state packets by entity type, by reason and by field.
#pragma once

#include "shared/core/ids.h"
#include "shared/core/json.h"
#include "shared/wire/declared/declared_codec.h"
#include "shared/wire/field_table.h"

#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace zoned::wire {

/// The reason why bytes were sent. A sender knows all of these. A receiver cannot distinguish
/// heartbeats and resends from updates.
enum class TrafficReason : std::uint8_t {
    kUpdate,     ///< truth left the bound, came to rest, or looks otherwise
    kKeyframe,   ///< an update, absolute, because a keyframe was due or the client held none
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

/// Parts of a record: the fields of the table, then these.
inline constexpr std::size_t kRecordHeadPart = kFields.size();
inline constexpr std::size_t kPaddingPart = kFields.size() + 1;
inline constexpr std::size_t kDeclaredPart = kFields.size() + 2;
inline constexpr std::size_t kRecordParts = kFields.size() + 3;
inline constexpr std::size_t kOwnStatePart = kRecordParts;
inline constexpr std::size_t kPacketHeadPart = kRecordParts + 1;
/// In records coded for one client: their base, their end and the padding to whole bytes.
inline constexpr std::size_t kCodeHeadPart = kRecordParts + 2;
inline constexpr std::size_t kTrafficParts = kRecordParts + 3;

[[nodiscard]] const char* traffic_part_name(std::size_t part);

/// Bits of one record, by part; their sum is eight times its bytes. For a record coded together
/// with others for one client, the bits are its information beyond the prediction, as whole bits of
/// the code.
using RecordBits = std::array<std::uint16_t, kRecordParts>;

/// Sums of bits. Bits outside records of entities (removals name no type) have no type.
class TrafficTable {
  public:
    using Row = std::array<std::array<std::uint64_t, kTrafficParts>, kTrafficReasons>;

    void add_record(TypeIndex type, TrafficReason reason, const RecordBits& bits);
    /// The values of declared fields among the bits of a record.
    void add_declared(const FieldSchema& schema, const DeclaredBits& bits);
    void add_removal(std::size_t bits);
    /// `own_bytes` of the `head_bytes` in all before the records are the own state.
    void add_packet(std::size_t head_bytes, std::size_t own_bytes);
    /// Bits of a coded packet that belong to none of its records.
    void add_code_head(std::size_t bits);
    /// Unreadable records.
    void add_unread(std::size_t bytes);
    void add(const TrafficTable& other);

    /// Rows: 0 is for bits of no type, 1 + i is type i. Types never met may be missing.
    [[nodiscard]] std::span<const Row> rows() const { return rows_; }

    [[nodiscard]] std::uint64_t packets() const { return packets_; }

    /// Of the values of declared fields, by name; control points are one row. What names and bounds them in a record is in
    /// kDeclaredPart beside them.
    struct DeclaredSum {
        std::string name;
        std::uint64_t bits = 0;
        std::uint64_t changes = 0;  ///< values sent
    };

    [[nodiscard]] std::span<const DeclaredSum> declared() const { return declared_; }

    [[nodiscard]] std::uint64_t bits() const;
    [[nodiscard]] std::uint64_t bits(TrafficReason reason) const;
    [[nodiscard]] std::uint64_t bits_of_part(std::size_t part) const;
    [[nodiscard]] std::uint64_t bits_of_part(std::size_t row, std::size_t part) const;
    [[nodiscard]] std::uint64_t bits_of_row(std::size_t row) const;
    [[nodiscard]] std::uint64_t bits(std::size_t row, TrafficReason reason) const;

  private:
    Row& row(std::size_t index);
    DeclaredSum& declared_sum(const std::string& name);

    std::vector<Row> rows_;
    std::vector<DeclaredSum> declared_;
    std::uint64_t packets_ = 0;
};

/// Members of an object that is open: bytes (bits / 8) of bodies by type, each by reason and field,
/// and of all types together.
void write_traffic(core::JsonWriter& json,
                   const TrafficTable& table,
                   std::span<const std::string> types);

/// A table for people: a line per type with its share by reason, and a line per field, both in
/// descending order; bars are to scale. `types` are the names by type index, `overhead_bytes` are
/// sent with each packet beside its body (headers, seal).
[[nodiscard]] std::string traffic_text(const TrafficTable& table,
                                       std::span<const std::string> types,
                                       double seconds,
                                       std::size_t overhead_bytes);

}  // namespace zoned::wire
