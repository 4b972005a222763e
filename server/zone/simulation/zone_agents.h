// Agents of a zone: the step, and bodies for those alone whose entities are simulated.
#pragma once

#include "server/zone/zone_state.h"

namespace zoned::zone {

/// What an update of the zone's agents reads and moves; `team` and `query` outlive it.
ai::AiContext context_of(ZoneState& state, compute::Team& team, const physics::Query* query);

/// Decisions and steering; who falls asleep loses the body, who wakes up gets it back. Returns how
/// many decided.
std::uint32_t update_agents(ZoneState& state);

/// Agents become those of another difficulty where what players did asks for it
/// (ai/difficulty.h), at most one change a tick, told in the report.
void follow_players(ZoneState& state);

/// An entity that something is done to must be simulated: wakes its agent where it has one that
/// goes from event to event.
void wake_agent(ZoneState& state, world::Row row);

}  // namespace zoned::zone
