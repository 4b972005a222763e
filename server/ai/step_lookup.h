// Step lookup: the machine, the row and the square of a mind, for the files of the step.
#pragma once

#include "server/ai/ai_step.h"
#include "shared/core/assert.h"

namespace zoned::ai {

inline const CompiledMachine& machine_of(const Mind& mind, const Settings& settings) {
    ZONED_ASSERT(mind.machine < settings.compiled.size(), "the machine of a mind exists");
    return settings.compiled[mind.machine];
}

/// The row of an entity whose mind may do something; kNoRow: leave it alone. `hint`: where it was.
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
inline Tick left_at(const Mind& mind, const World& world) {
    return CoarseCells::left_at(mind.leg, mind.placed, world.half_size, world.dt);
}

}  // namespace zoned::ai
