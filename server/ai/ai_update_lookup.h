// AiUpdate lookup: the brain, the row and the square of an agent, and work in lanes, for the files
// of the step.
#pragma once

#include "server/ai/ai_update.h"
#include "shared/core/assert.h"

#include <algorithm>

namespace zoned::ai {

inline const CompiledBrain& brain_of(const Agent& agent, const AiSettings& settings) {
    ZONED_ASSERT(agent.brain < settings.compiled.size(), "the brain of an agent exists");
    return settings.compiled[agent.brain];
}

/// Whether an agent steers in this tick: where no player is near, it does so now and then only.
/// A state that was just entered begins at once, so that no command is ever repeated into it.
inline bool steers_now(const Agent& agent, const AiSettings& settings, Tick now) {
    return !settings.reduce_far || !agent.far || agent.entered || now >= agent.next_steering;
}

inline bool has_herds(const AiSettings& settings) {
    return std::any_of(settings.compiled.begin(),
                       settings.compiled.end(),
                       [](const CompiledBrain& brain) { return brain.flocks; });
}

/// The row of an entity whose agent may do something; kNoRow: leave it alone. `hint`: where it was.
inline world::Row row_of(const world::Entities& entities,
                         EntityId entity,
                         world::Row hint = world::kNoRow) {
    const bool known = hint < entities.size() && entities.id[hint] == entity;
    const world::Row row = known ? hint : entities.find(entity);
    return row != world::kNoRow &&
                   (entities.has(row, world::kHidden) || entities.has(row, world::kGhost))
               ? world::kNoRow
               : row;
}

/// When it leaves the square that its entity is in.
inline Tick left_at(const Agent& agent, const AiContext& world, bool goes_on = false) {
    return OffscreenGrid::left_at(agent.segment, agent.placed, world.half_size, world.dt, goes_on);
}

/// Calls work(lane, begin, end) for consecutive ranges that cover [0, count).
template <class Work>
void AiUpdate::in_lanes(compute::Team& team, std::size_t count, Work&& work) {
    if (count < kShared) {
        work(lanes_[0], std::size_t{0}, count);
        return;
    }
    const compute::Team::Shift shift(team);
    team.run(kLanes, 1, [&](std::size_t first, std::size_t last) {
        for (std::size_t lane = first; lane < last; ++lane) {
            work(lanes_[lane], count * lane / kLanes, count * (lane + 1) / kLanes);
        }
    });
}

}  // namespace zoned::ai
