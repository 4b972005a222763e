// Perception: what an agent notices of those around it: players and others whom it looks for, by
// percept and hearing, and what it remembers of them.
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

/// Rays that one look may cast: at its target of before and at the nearest others.
inline constexpr std::uint32_t kRaysPerLook = 4;

/// Players are the rows with a client that are not hidden, ghosts included; `self` is not a player
/// to itself. Of players equally near the one with the smaller id counts, whatever the order of
/// rows. Radii in m, > 0.
Percept look(const world::Entities& entities,
             const spatial::PointGrid& grid,
             world::Row self,
             float perception_m,
             float far_m);

/// The players alone, who are few among many: near whom is asked about them all the time.
struct Players {
    spatial::PointGrid grid;       ///< of `at`
    std::vector<world::Row> rows;  ///< of entities, by index into `at`
    std::vector<Vec3> at;

    /// Finds them among the entities, ascending by row.
    void gather(const world::Entities& entities);
};

/// Who goes by a timetable is perceived where that says, and by one that is where its own says:
/// so it is perceived at the same tick however closely its body has kept to it.
struct Timetables {
    const AgentStore& agents;
    std::span<const std::uint32_t> slots;  ///< by row: of its agent; others may be in the way
};

/// look(), unless the brain says how its agents perceive. Then a target is noticed
/// - by percept: within perception_m, and within the cone about the facing or within around_m, and
///   where line_of_sight asks for it nothing static between eyes and eyes;
/// - by hearing: within hearing_m, and within the target's own aura for its stance, times its speed
///   as a share of walking (at most sprinting): who stands makes no sound.
/// Of those noticed the nearest counts, of equals the smaller id, or the target of before where
/// keeps_target says so. At most kRaysPerLook rays are cast, so that with line_of_sight the nearest
/// few are looked at. Where none is noticed the target of before is remembered where it was, with a
/// confidence that falls in a straight line to 0 over memory_s; then it is forgotten. A ward is
/// known within perception_m, the one of before as long as it is there.
/// `players`: null: they are looked for in ai.near. `timetables`: null: all are where their bodies
/// are.
Percept perceive(const AiContext& ai,
                 world::Row self,
                 const Agent& agent,
                 const CompiledBrain& brain,
                 const Players* players = nullptr,
                 const Timetables* timetables = nullptr);

}  // namespace zoned::ai
