// Spawning: bodies and agents of entities that come into a zone and leave it.
#pragma once

#include "server/zone/zone_state.h"

namespace zoned::zone {

/// World-wide unique id, see EntityId.
EntityId next_entity_id(ZoneState& state);

/// Adds the body that an owned, visible entity's type asks for, rigid (remembered in the columns)
/// or soft; a soft ghost gets none.
void add_body(ZoneState& state, world::Row row, bool asleep);
/// Removes the body if there is one, rigid or soft.
void remove_body(ZoneState& state, world::Row row);
/// Gives an owned entity the agent of its type, if the type has one.
void add_agent(ZoneState& state, world::Row row);

}  // namespace zoned::zone
