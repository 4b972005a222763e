// Publication records: one encoded state of one entity at one level of detail, encoded once for all
// subscribers.
#pragma once

#include "shared/core/ids.h"
#include "shared/core/result.h"
#include "shared/wire/bit_stream.h"
#include "shared/wire/declared/declared_codec.h"
#include "shared/wire/field_table.h"
#include "shared/wire/quantize.h"
#include "shared/wire/traffic.h"

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

namespace zoned::wire {

/// Kinds of records in a state packet.
enum class RecordKind : std::uint8_t {
    kAbsolute =
        0,  ///< all fields; becomes keyframe number `keyframe` of its (zone, entity, lod) stream
    kDelta = 1,   ///< fields against keyframe `keyframe` of the stream
    kRemove = 2,  ///< the entity left this client's view (or the world)
};

inline constexpr int kKeyframeNumbers = 16;  ///< keyframe numbers count modulo 16

/// The part of a record that is readable without knowing type or keyframe.
struct RecordHead {
    RecordKind kind = RecordKind::kAbsolute;
    EntityId entity;
    std::uint8_t lod = 0;       ///< 0..kLods-1
    std::uint8_t keyframe = 0;  ///< 0..kKeyframeNumbers-1; absent (0) in kRemove
    std::uint8_t tick_low = 0;  ///< publication tick modulo 256; absent in kRemove
    TypeIndex type = 0;         ///< kAbsolute only
    bool upright = false;       ///< read from the record; encoders write their own argument instead
    bool declared = false;      ///< likewise: declared fields follow the state
};

/// A record without declared fields never takes more bytes than this, whatever the Quantization.
inline constexpr std::size_t kMaxRecordBytes = 64;

/// The declared fields that a record carries; of a `mask` of 0 none.
struct DeclaredPart {
    const FieldSchema* schema = nullptr;
    std::span<const std::uint32_t> words;  ///< of all fields of the entity
    FieldMask mask = 0;  ///< absolute: those that are not initial; delta: changed since then
};

/// A publication's tick from its low byte: the newest tick <= packet_tick with these low bits.
Tick expand_tick(std::uint8_t tick_low, Tick packet_tick);

/// Appends a byte-aligned absolute record. `state` is quantised by at_lod(q, head.lod), `q` the
/// world's Quantization. `upright` must match head.type in the type table.
void encode_absolute(const RecordHead& head,
                     const QuantizedState& state,
                     bool upright,
                     const Quantization& q,
                     std::vector<std::uint8_t>& out,
                     const DeclaredPart& declared = {});

/// Appends a byte-aligned delta record: only the fields that differ from `keyframe`, small
/// differences in few bits.
void encode_delta(const RecordHead& head,
                  const QuantizedState& state,
                  const QuantizedState& keyframe,
                  bool upright,
                  const Quantization& q,
                  std::vector<std::uint8_t>& out,
                  const DeclaredPart& declared = {});

/// Appends a remove record.
void encode_remove(EntityId entity, std::vector<std::uint8_t>& out);

/// Reads the records of one packet one after another. Bytes are hostile: every read may fail, never
/// crash. Use: while (!r.done()) { head = r.next_head(); then exactly one of read_absolute /
/// read_delta / skip_delta unless kRemove; after one of the first two read_declared where
/// head.declared. } After a failure the rest cannot be found: done() is true then. Only canonical
/// bytes are accepted: what was read encodes to the same bytes again.
class RecordReader {
  public:
    RecordReader(std::span<const std::uint8_t> bytes, const Quantization& q)
        : bits_(bytes),
          quantization_(q) {}

    [[nodiscard]] bool done() const { return bits_.failed() || malformed_ || bits_.at_end(); }

    /// Offset of the next record.
    [[nodiscard]] std::size_t byte_offset() const { return bits_.byte_offset(); }

    core::Result<RecordHead> next_head();
    /// Fails also when the record contradicts `upright`, the value of the type table.
    core::Result<QuantizedState> read_absolute(bool upright);
    /// `keyframe` must be a state that quantize() or a reader gave.
    core::Result<QuantizedState> read_delta(const QuantizedState& keyframe, bool upright);
    /// The declared fields of the record whose state was just read. `schema`: of its type; null:
    /// the type has none, which is refused. After a fault the rest of the packet cannot be found.
    DeclaredFault read_declared(const FieldSchema* schema, DeclaredUpdate& update);
    /// Skips the state of a delta whose keyframe is unknown (the length does not depend on the
    /// keyframe's values). For an entity whose type is unknown pass head.upright.
    core::Result<bool> skip_delta(bool upright);
    /// Reads a whole record in place of the above, and counts the bits of each part; a removal is
    /// only a head. Neither keyframe nor type are needed; values are not checked.
    core::Result<RecordHead> measure_next(RecordBits& bits);
    /// The bits of each declared field of the record that was measured last.
    [[nodiscard]] DeclaredBits measured_declared(const FieldSchema& schema) const;

  private:
    core::Result<QuantizedState> read_state(const Columns& reference,
                                            RecordKind kind,
                                            bool upright);
    void begin_state(RecordKind kind);
    const FieldLayout& layout();

    BitReader bits_;
    Quantization quantization_;                              // of the world
    std::array<std::optional<FieldLayout>, kLods> layouts_;  // by level, made when first read
    RecordHead head_;
    BitReader declared_at_;  // of the record that was measured last
    bool state_pending_ = false;
    bool declared_pending_ = false;
    bool malformed_ = false;
};

}  // namespace zoned::wire
