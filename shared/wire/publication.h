// Publication records: one encoded state of one entity at one level of detail, encoded once for all
// subscribers.
#pragma once

#include "shared/core/ids.h"
#include "shared/core/result.h"
#include "shared/wire/quantize.h"

#include <cstdint>
#include <span>
#include <vector>

namespace zoned::wire {

/// What a record in a state packet is.
enum class RecordKind : std::uint8_t {
    kAbsolute =
        0,  ///< all fields; becomes keyframe number `keyframe` of its (zone, entity, lod) stream
    kDelta = 1,   ///< fields against keyframe `keyframe` of the stream
    kRemove = 2,  ///< the entity left this client's view (or the world)
};

inline constexpr int kKeyframeNumbers = 16;  ///< keyframe numbers count modulo 16
inline constexpr int kLods = 4;              ///< levels of detail, 0 is the nearest
inline constexpr std::uint8_t kRemoveLod = 0;

/// The part of a record that is readable without knowing type or keyframe.
struct RecordHead {
    RecordKind kind = RecordKind::kAbsolute;
    EntityId entity;
    std::uint8_t lod = 0;       ///< 0..kLods-1
    std::uint8_t keyframe = 0;  ///< 0..kKeyframeNumbers-1; absent (0) in kRemove
    std::uint8_t tick_low = 0;  ///< publication tick modulo 256; absent in kRemove
    TypeIndex type = 0;         ///< kAbsolute only
};

/// A publication's tick from its low byte: the newest tick <= packet_tick with these low bits.
Tick expand_tick(std::uint8_t tick_low, Tick packet_tick);

/// Appends a byte-aligned absolute record. `upright` must be what the type table says of head.type.
void encode_absolute(const RecordHead& head,
                     const QuantizedState& state,
                     bool upright,
                     const Quantization& q,
                     std::vector<std::uint8_t>& out);

/// Appends a byte-aligned delta record: only the fields that differ from `keyframe`, small
/// differences in few bits.
void encode_delta(const RecordHead& head,
                  const QuantizedState& state,
                  const QuantizedState& keyframe,
                  bool upright,
                  const Quantization& q,
                  std::vector<std::uint8_t>& out);

/// Appends a remove record.
void encode_remove(EntityId entity, std::vector<std::uint8_t>& out);

/// Reads the records of one packet one after another. Bytes are hostile: every read may fail, never
/// crash. Use: while (!r.done()) { head = r.next_head(); then exactly one of read_absolute /
/// read_delta unless kRemove. }
class RecordReader {
  public:
    RecordReader(std::span<const std::uint8_t> bytes, const Quantization& q)
        : bytes_(bytes),
          q_(&q) {}

    [[nodiscard]] bool done() const { return offset_ >= bytes_.size(); }

    core::Result<RecordHead> next_head();
    core::Result<QuantizedState> read_absolute(bool upright);
    core::Result<QuantizedState> read_delta(const QuantizedState& keyframe, bool upright);
    /// Skips the state of a delta whose keyframe is unknown (the length does not depend on the
    /// keyframe's values).
    core::Result<bool> skip_delta(bool upright);

  private:
    std::span<const std::uint8_t> bytes_;
    const Quantization* q_;
    std::size_t offset_ = 0;
    RecordHead head_;
};

}  // namespace zoned::wire
