// SoftHull: soft bodies that nobody is near are simulated as rigid ones, and as themselves again.
#pragma once

#include "server/zone/zone_state.h"

namespace zoned::zone {

/// From now on an owned, visible soft body without pins is the rigid hull of its nodes as they are,
/// and moves on as these did together. False, and nothing changes, where no rigid body can be made
/// of it. Allocates.
bool step_down_soft(ZoneState& state, world::Row row);

/// It is its nodes again, where the hull is and moving as it does, deformed as they were. Nothing
/// happens to what is soft, or rigid by its type. Whoever is to move, hide or hand on a soft body
/// does this first.
void step_up_soft(ZoneState& state, world::Row row);

/// The entity's orientation where its hull has `turn`; `turn` itself for what has none.
Quat turn_of_hull(const ZoneState& state, world::Row row, const Quat& turn);

}  // namespace zoned::zone
