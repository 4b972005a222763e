// Entities: the columns that all stages of a zone share, one row per entity, owned ones and ghosts
// alike.
#pragma once

#include "server/world/entity_type.h"
#include "shared/core/ids.h"
#include "shared/math/types.h"
#include "shared/motion/input_command.h"
#include "shared/motion/kinematic_state.h"

#include <cstdint>
#include <unordered_map>
#include <vector>

namespace zoned::world {

using Row = std::uint32_t;
inline constexpr Row kNoRow = 0xFFFFFFFFu;

enum EntityFlag : std::uint8_t {
    kGhost = 1u << 0,     ///< read-only copy of a neighbour zone's entity
    kAtRest = 1u << 1,    ///< does not move at all (a sleeping body, a character that stands):
                          ///< velocities are exactly zero
    kGrounded = 1u << 2,  ///< characters: carried by the ground
    kHidden = 1u << 3,    ///< nobody hears of it (carried in an inventory, dead and waiting)
};

/// Rows are dense; removal moves the last row into the gap, so a Row is valid only until the next
/// removal. All vectors have size() elements. Positions are zone-local metres.
class Entities {
  public:
    std::vector<EntityId> id;
    std::vector<TypeIndex> type;
    std::vector<std::uint8_t> flags;  ///< EntityFlag bits
    std::vector<Vec3> position;
    std::vector<Quat> orientation;
    std::vector<Vec3> velocity;
    std::vector<Vec3> angular_velocity;
    std::vector<Vec3>
        acceleration;  ///< of the last tick, smoothed by nobody: (v - v_previous) / dt
    std::vector<std::uint16_t> yaw;         ///< characters: facing
    std::vector<std::uint16_t> appearance;  ///< rules' visible state, replicated on change
    std::vector<std::uint8_t> behaviour;    ///< Behaviour index of the behavioural radii
    std::vector<BodyId> body;      ///< in the zone's physics scene; none for hidden entities
    std::vector<ClientId> client;  ///< the client whose avatar this is, or none
    std::vector<motion::InputCommand> command;  ///< characters: consumed by the next movement pass
    std::vector<std::uint8_t> representation;   ///< props: as what they are simulated, see zone
    std::vector<Tick> discontinuity_tick;       ///< last spawn, teleport or unhide: nobody can have
                                                ///< predicted across it

    [[nodiscard]] std::size_t size() const { return id.size(); }

    /// Adds a row with defaults; `entity` must be new.
    Row add(EntityId entity, TypeIndex entity_type);
    void remove(Row row);
    /// kNoRow when the entity is not here.
    [[nodiscard]] Row find(EntityId entity) const;

    [[nodiscard]] bool has(Row row, EntityFlag flag) const { return (flags[row] & flag) != 0; }

    void set(Row row, EntityFlag flag, bool on) {
        flags[row] = static_cast<std::uint8_t>(on ? (flags[row] | flag) : (flags[row] & ~flag));
    }

    [[nodiscard]] motion::KinematicState kinematic(Row row) const {
        return {position[row],
                orientation[row],
                velocity[row],
                acceleration[row],
                angular_velocity[row]};
    }

  private:
    std::unordered_map<EntityId, Row> row_of_;
};

}  // namespace zoned::world
