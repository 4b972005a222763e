// Riding: characters that an entity carries: they move with it and not by their commands.
#pragma once

#include "server/zone/zone_state.h"

namespace zoned::zone {

/// A character of this zone without an agent gets onto an owned prop, `place` from the carrier's
/// centre along its axes, m. It collides with nothing that moves while it rides. With `drives`, the
/// controls of that root's assembly follow its stick. False where it may not, or rides already.
bool mount(ZoneState& state, EntityId rider, EntityId carrier, const Vec3& place, EntityId drives);
/// Ends the ride, if there is one: it walks again from where it is, at the speed that it has.
void dismount(ZoneState& state, EntityId rider);
/// Nobody rides on the entity any more, nor does it ride.
void end_rides_of(ZoneState& state, EntityId entity);

/// The ride of a character of this zone, or nullptr.
const Rider* ride_of(const ZoneState& state, EntityId rider);
/// The ride of a character that comes from another zone with its carrier.
void give_ride(ZoneState& state, const Rider& rider);
/// Takes it out, for another zone.
void take_ride(ZoneState& state, EntityId rider);

/// Puts the riders where their carriers are after a step. Returns how many.
std::uint32_t carry_riders(ZoneState& state);

}  // namespace zoned::zone
