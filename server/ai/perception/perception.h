// Perception: how an agent notices players and other entities by sight and hearing, and what it
// remembers of them.
#pragma once

#include "server/ai/agent/agent.h"
#include "server/ai/agent/percept.h"
#include "server/ai/ai_context.h"
#include "server/spatial/point_grid.h"
#include "server/world/entities.h"

#include <limits>
#include <span>
#include <vector>

namespace zoned::ai {

class AgentStore;

/// Rays that one look may cast: at its previous target, and at the nearest other entities.
inline constexpr std::uint32_t kRaysPerLook = 4;

/// Finds the nearest player. Players are the rows with a client that are not hidden, ghosts
/// included. `self` is not a player to itself. Of players equally near the one with the smaller id
/// counts, whatever the order of rows. Radii in m, > 0.
Percept look(const world::Entities& entities,
             const spatial::PointGrid& grid,
             world::Row self,
             float perception_m,
             float far_m);

/// The players alone. They are few among many entities, and agents ask all the time for the players
/// near them.
struct Players {
    spatial::PointGrid grid;       ///< of `at`
    std::vector<world::Row> rows;  ///< of entities, by index into `at`
    std::vector<Vec3> at;

    /// Finds the players among the entities, ascending by row.
    void gather(const world::Entities& entities);
};

/// An agent on a timetable is perceived at the position that its timetable gives. A perceiving
/// agent on a timetable also uses its own. So an entity is perceived at the same tick however
/// closely its body has kept to the timetable.
struct Timetables {
    const AgentStore& agents;
    std::span<const std::uint32_t> slots;  ///< by row: of its agent, or of another
};

/// Does look(), unless the brain sets how its agents perceive. Then there are two senses:
/// - By sight an agent notices a target within perception_m, in its cone of vision or within
///   around_m. With line_of_sight, no static geometry may lie between the eyes of both.
/// - By hearing it notices a target within hearing_m, and within a share of the target's own aura
///   for its stance. The share is the target's speed relative to walking (at most sprinting). A
///   standing target makes no sound.
/// The nearest noticed target counts; of equals, the smaller id. With keeps_target, the previous
/// target counts instead. At most kRaysPerLook rays are cast, so with line_of_sight only the
/// nearest few are checked.
///
/// If no target is noticed, the previous one is remembered where it was. The confidence falls
/// linearly to 0 over memory_s; then the target is forgotten. A ward is known within perception_m.
/// The previous ward stays the ward as long as it is there. With succession and no ward, of an
/// agent and those of its type within perception_m the one with the least id is the ward of the
/// others.
///
/// `players`: null: they are looked for in ai.near. `timetables`: null: all entities are perceived
/// at their bodies.
Percept perceive(const AiContext& ai,
                 world::Row self,
                 const Agent& agent,
                 const CompiledBrain& brain,
                 const Players* players = nullptr,
                 const Timetables* timetables = nullptr);

}  // namespace zoned::ai
