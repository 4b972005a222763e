// Entities: the columns that all stages of a zone share, one row per entity, owned ones and ghosts
// alike.
#pragma once

#include "server/world/entity_type.h"
#include "server/world/field_columns.h"
#include "server/world/row_set.h"
#include "shared/core/containers/id_table.h"
#include "shared/core/ids.h"
#include "shared/math/types.h"
#include "shared/motion/input_command.h"
#include "shared/motion/kinematic_state.h"

#include <array>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

namespace zoned::world {

enum EntityFlag : std::uint8_t {
    kGhost = 1u << 0,     ///< read-only copy of a neighbour zone's entity
    kAtRest = 1u << 1,    ///< does not move at all (a sleeping body, a character that stands):
                          ///< velocities are exactly zero
    kGrounded = 1u << 2,  ///< characters: carried by the ground
    kHidden = 1u << 3,    ///< no viewer hears of it (carried in an inventory, dead and waiting)
    kCarried = 1u << 5,   ///< characters: a rider, which its carrier moves
    kBeyond = 1u << 6,  ///< so far out that states cannot tell its position: no viewer hears of it
    kDozing = 1u << 4,  ///< its agent is suspended and goes from event to event: nothing else moves
                        ///< it, and code that writes one of its columns calls Entities::touch()
};

/// A column that everybody reads and Entities alone writes, which keeps sets and counts by it.
template <class T>
class KeptColumn {
  public:
    [[nodiscard]] const T& operator[](std::size_t row) const { return values_[row]; }

    [[nodiscard]] const T* data() const { return values_.data(); }

    [[nodiscard]] std::size_t size() const { return values_.size(); }

    [[nodiscard]] auto begin() const { return values_.begin(); }

    [[nodiscard]] auto end() const { return values_.end(); }

  private:
    friend class Entities;
    std::vector<T> values_;
};

/// Flags by which no viewer hears of an entity.
inline constexpr std::uint8_t kUnheard = kHidden | kBeyond;

/// The consumers that each go over the rows touched since their last pass.
enum class Reader : std::uint8_t {
    kHash,
    kExport,
    kInterest,
    kGrid,
    kTriggers
};
inline constexpr std::size_t kReaders = 5;

/// Rows are dense; removal moves the last row into the gap, so a Row is valid only until the next
/// removal. All vectors have size() elements. Positions are zone-local metres.
///
/// A pass costs only the active rows: it walks a set of rows that is kept where flags change, and
/// not all.
class Entities {
  public:
    /// Of one type.
    struct Count {
        std::uint32_t ghosts = 0;
        std::uint32_t owned = 0;
        std::uint32_t shown = 0;  ///< of those owned: not hidden
    };

    std::vector<EntityId> id;
    KeptColumn<TypeIndex> type;
    KeptColumn<std::uint8_t> flags;  ///< EntityFlag bits
    std::vector<Vec3> position;
    std::vector<Quat> orientation;
    std::vector<Vec3> velocity;
    std::vector<Vec3> angular_velocity;
    std::vector<Vec3>
        acceleration;  ///< of the last tick, smoothed by nobody: (v - v_previous) / dt
    std::vector<std::uint16_t> yaw;         ///< characters: facing
    std::vector<std::uint16_t> appearance;  ///< rules' visible state, replicated on change
    std::vector<std::uint8_t> stance;       ///< Stance index of the behavioural radii
    std::vector<BodyId> body;     ///< in the zone's physics scene; none for hidden entities
    KeptColumn<ClientId> client;  ///< the client whose avatar this is, or none
    std::vector<motion::InputCommand> command;  ///< characters: consumed by the next movement pass
    KeptColumn<std::uint8_t> representation;    ///< props: their simulated representation, see zone
    std::vector<Tick> discontinuity_tick;       ///< last spawn, teleport or unhide: nobody can have
                                                ///< predicted across it

    [[nodiscard]] std::size_t size() const { return id.size(); }

    /// Adds a row with defaults; `entity` must be new.
    Row add(EntityId entity, TypeIndex entity_type);
    void remove(Row row);

    /// kNoRow when the entity is not here.
    [[nodiscard]] Row find(EntityId entity) const {
        const Row* row = row_of_.find(entity.value);
        return row == nullptr ? kNoRow : *row;
    }

    [[nodiscard]] bool has(Row row, EntityFlag flag) const { return (flags[row] & flag) != 0; }

    void set(Row row, EntityFlag flag, bool on) {
        set_flags(row, static_cast<std::uint8_t>(on ? (flags[row] | flag) : (flags[row] & ~flag)));
    }

    /// All of them.
    void set_flags(Row row, std::uint8_t to) {
        if (flags[row] != to) {
            change_flags(row, to);
        }
    }

    /// Before the first row: the declared fields of each type.
    void declare_fields(wire::FieldSchemas schemas) { fields_.declare(std::move(schemas)); }

    /// Before the first row: what the kept sets ask of each type. Without it every type is taken
    /// for one that may act at rest, and the sets by type stay empty.
    void declare_types(const TypeTable& types);

    [[nodiscard]] const FieldColumns& fields() const { return fields_; }

    /// The values of the declared fields of a row; empty where its type has none.
    [[nodiscard]] std::span<const std::uint32_t> field_values(Row row) const {
        return fields_.values(row, type[row]);
    }

    /// Of a row whose type declares `field`; touches it where the value changes.
    void put_field(Row row,
                   const wire::DeclaredField& field,
                   std::span<const std::uint32_t> words,
                   Tick now) {
        if (fields_.put(row, type[row], field, words, now)) {
            touch(row);
        }
    }

    /// Takes over the fields of another zone's copy of the entity.
    void put_field_block(Row row, std::span<const std::uint32_t> words) {
        fields_.put_block(row, type[row], words);
    }

    void set_client(Row row, ClientId to);
    void set_type(Row row, TypeIndex to);
    void set_representation(Row row, std::uint8_t to);

    /// Rows without kAtRest.
    [[nodiscard]] const RowSet& moving() const { return moving_; }

    /// Rows that something may happen to without a word: all but props that rest, and characters
    /// that rest and doze.
    [[nodiscard]] const RowSet& stirring() const { return stirring_; }

    /// Rows with a client.
    [[nodiscard]] const RowSet& avatars() const { return avatars_; }

    /// Rows of characters.
    [[nodiscard]] const RowSet& characters() const { return characters_; }

    /// Rows of characters without a brain: those of players.
    [[nodiscard]] const RowSet& players() const { return players_; }

    /// Rows of rewindable types.
    [[nodiscard]] const RowSet& rewindable() const { return rewindable_; }

    /// Rows with another representation than the full one.
    [[nodiscard]] const RowSet& reduced() const { return reduced_; }

    /// A character that rests has changed, for the hash; a prop that rests and an agent that dozes,
    /// for all readers. Rows that are added, take the place of another or change flags are touched
    /// without a word.
    void touch(Row row) {
        for (RowSet& touched : touched_) {
            touched.put(row, true);
        }
    }

    /// A prop stirred and came to rest again within one step: for all readers but the hash, which
    /// takes a prop in when its flags change and while it stirs.
    void touch_passing(Row row) {
        for (const Reader reader : {Reader::kExport, Reader::kInterest, Reader::kGrid}) {
            touched_[static_cast<std::size_t>(reader)].put(row, true);
        }
    }

    [[nodiscard]] const RowSet& touched(Reader reader) const {
        return touched_[static_cast<std::size_t>(reader)];
    }

    /// The reader has seen them all.
    void forget_touched(Reader reader) { touched_[static_cast<std::size_t>(reader)].clear(); }

    /// By type; types beyond its end have no entities.
    [[nodiscard]] const std::vector<Count>& counts() const { return counts_; }

    /// Prefetches the columns that an agent reads of a row soon; the row need not be there.
    void prefetch(Row row) const {
        if (row < size()) {
            __builtin_prefetch(&id[row]);
            __builtin_prefetch(&flags[row]);
            __builtin_prefetch(&type[row]);
            __builtin_prefetch(&position[row]);
            __builtin_prefetch(&stance[row]);
            __builtin_prefetch(&discontinuity_tick[row]);
        }
    }

    /// Everything, rows in their order and what each reader has not seen yet.
    template <class Archive>
    void serialize(Archive& archive) {
        archive(id, type.values_, flags.values_, position, orientation, velocity);
        archive(angular_velocity, acceleration, yaw, appearance, stance, body, client.values_);
        archive(command, representation.values_, discontinuity_tick);
        archive(moving_, stirring_, avatars_, touched_, counts_, fields_);
        if constexpr (Archive::kReads) {
            if (!find_rows()) {
                archive.fail("columns of entities differ in length, or an entity comes twice");
            }
        }
    }

    [[nodiscard]] motion::KinematicState kinematic(Row row) const {
        return {position[row],
                orientation[row],
                velocity[row],
                acceleration[row],
                angular_velocity[row]};
    }

  private:
    /// What the kept sets ask of a type.
    enum TypeTrait : std::uint8_t {
        kActsAtRest = 1u << 0,  ///< a command may move it without a word
        kPlayer = 1u << 1,
        kRewindable = 1u << 2,
        kIsCharacter = 1u << 3,
    };

    [[nodiscard]] std::uint8_t traits(TypeIndex of) const {
        return of < traits_.size() ? traits_[of] : std::uint8_t{kActsAtRest};
    }

    [[nodiscard]] bool stirs(TypeIndex of, std::uint8_t with) const {
        return (with & kAtRest) == 0 || ((with & kDozing) == 0 && (traits(of) & kActsAtRest) != 0);
    }

    void put_by_type(Row row);
    void change_flags(Row row, std::uint8_t to);
    void count(TypeIndex of, std::uint8_t with, std::uint32_t more);
    /// Makes `row_of_` anew; false where the columns do not fit each other.
    [[nodiscard]] bool find_rows();

    core::IdTable<Row> row_of_;
    RowSet moving_;
    RowSet stirring_;
    RowSet avatars_;
    RowSet characters_;
    RowSet players_;
    RowSet rewindable_;
    RowSet reduced_;
    std::vector<std::uint8_t> traits_;  // TypeTrait bits by type
    std::array<RowSet, kReaders> touched_;
    std::vector<Count> counts_;
    FieldColumns fields_;
};

}  // namespace zoned::world
