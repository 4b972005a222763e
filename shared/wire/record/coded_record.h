// Coded records: the publications in a packet for one client, and the decisions learned from coding
// them.
#pragma once

#include "shared/wire/entropy/acknowledged.h"
#include "shared/wire/entropy/least_squares.h"
#include "shared/wire/publication.h"
#include "shared/wire/record/course.h"
#include "shared/wire/traffic.h"

#include <array>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

namespace zoned::wire::record {

/// One publication, or the removal of an entity from the client's view.
struct CodedRecord {
    EntityId entity;
    bool remove = false;  ///< then all other members are ignored
    std::uint8_t lod = 0;
    TypeIndex type = 0;
    bool upright = false;
    /// 1 + index in RecordFrame::declared; 0: its type has no declared fields.
    std::uint32_t declared = 0;
    Tick tick = 0;         ///< of the publication, at most the packet's and kOldestTicks before it
    QuantizedState state;  ///< by the level's quantisation
    // Filled in by coding, where the state was predicted by the entity's course; else 0.
    std::array<float, 3> error{};  ///< of the prediction, steps per tick
    float turn_error = 0.0F;       ///< likewise, mean over the axes, rad per tick
    bool plain = false;            ///< the prediction was no use: earlier places say nothing of it
};

/// Older publications travel as shared records.
inline constexpr Tick kOldestTicks = 4095;

/// The number format of a level of detail.
struct LevelFormat {
    explicit LevelFormat(const Quantization& of_level)
        : quantization(of_level),
          limits(limits_of(of_level)),
          layout(of_level) {}

    Quantization quantization;
    QuantizationLimits limits;
    FieldLayout layout;
};

/// Constants of all packets, known to both sides.
struct RecordFormat {
    /// `world`: the world's quantisation.
    RecordFormat(const Quantization& world, float seconds_per_tick, FieldSchemas declared = {})
        : tick_s(seconds_per_tick),
          fields(std::move(declared)) {
        for (std::uint8_t lod = 0; lod < kLods; ++lod) {
            levels.emplace_back(at_lod(world, lod));
        }
    }

    std::vector<LevelFormat> levels;  ///< kLods
    float tick_s;
    FieldSchemas fields;  ///< by type
};

/// The declared fields of an entity as they were published.
struct DeclaredValues {
    std::span<const std::uint32_t> words;
    std::span<const Tick> changed;  ///< of each field: tick of the publication that changed it
};

/// The declared fields that an encoder asks for.
class DeclaredSource {
  public:
    virtual ~DeclaredSource() = default;
    /// Of an entity whose type has some.
    [[nodiscard]] virtual DeclaredValues declared_of(EntityId entity) const = 0;
};

/// Residuals of a field are expected to be as large as the recent ones, separately by reach, the
/// length of the extrapolation: up to 2, 8, 32 and more ticks; or from nothing at all.
inline constexpr std::size_t kReaches = 5;
inline constexpr std::size_t kFromNothing = kReaches - 1;

/// A coded decision, with its model and reach.
struct RecordModelUpdate {
    std::uint16_t model = 0;
    std::uint8_t reach = 0;
    std::uint8_t symbol = 0;
};

/// A packet as it was coded. Never changes afterwards.
struct RecordFrame {
    entropy::PacketNumber number = 0;
    Tick tick = 0;
    ZoneId zone;
    std::vector<CodedRecord> records;  ///< ascending by entity
    std::vector<RecordModelUpdate> model_updates;
    std::array<entropy::NormalSums<1>, 2> velocity;  ///< along the ground, upwards
    std::vector<CourseSums> course;                  ///< one, or none where nothing is on a course
    std::vector<RecordBits> bits;  ///< of each record, where they are measured; the rest of the
                                   ///< code's bytes is its head and end
    std::vector<DeclaredUpdate> declared;     ///< of decoded records
    std::vector<DeclaredBits> declared_bits;  ///< of them, where they are measured

    /// Empties the lists, which keep their memory.
    void clear() {
        records.clear();
        model_updates.clear();
        bits.clear();
        declared.clear();
        declared_bits.clear();
        course.clear();
        velocity = {};
    }
};

}  // namespace zoned::wire::record
