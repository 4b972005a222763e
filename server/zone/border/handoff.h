// Handoff: moves entities whose centre left the region to the zone where it lies, contact islands
// as a whole.
#pragma once

#include "server/zone/zone_state.h"

namespace zoned::zone {

/// Moves entities that must go from the state into state.out.handoffs; from then on this zone does
/// not own them. An entity goes when it lies farther outside than the hysteresis. Bodies in contact
/// go together, by their mean centre. An island that touches a ghost, or is about to, goes to the
/// ghost's zone when that has the lower number. Entities that left the world are put back inside
/// and counted. Returns how many left.
std::uint32_t hand_off(ZoneState& state);

/// Takes over an entity that another zone handed off.
void accept(ZoneState& state, Handoff& handoff);

}  // namespace zoned::zone
