// SoftHull: turns soft bodies that nobody is near into rigid ones, and back.
#pragma once

#include "server/zone/zone_state.h"

namespace zoned::zone {

/// Makes an owned, visible soft body without pins the rigid hull of its nodes as they are; the hull
/// moves on as the nodes did together. False, and nothing changes, where no rigid body can be made
/// of it. Allocates.
bool step_down_soft(ZoneState& state, world::Row row);

/// The body is its nodes again, where the hull is and moving as it does, deformed as they were.
/// Nothing happens to a body that is soft, or rigid by its type. Code that moves, hides or hands on
/// a soft body calls this first.
void step_up_soft(ZoneState& state, world::Row row);

/// The entity's orientation where its hull has `turn`; `turn` itself for an entity without a hull.
Quat turn_of_hull(const ZoneState& state, world::Row row, const Quat& turn);

}  // namespace zoned::zone
