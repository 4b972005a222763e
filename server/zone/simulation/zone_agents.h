// Zone agents: updates the agents of a zone; only the simulated entities among them get bodies.
#pragma once

#include "server/zone/zone_state.h"

namespace zoned::zone {

/// The input of an update of the zone's agents; `team` and `query` outlive it.
ai::AiContext context_of(ZoneState& state, compute::Team& team, const physics::Query* query);

/// Decisions and steering. A suspended agent loses its body, and a resumed one gets it back.
/// Returns how many decided.
std::uint32_t update_agents(ZoneState& state);

/// Moves agents to another difficulty where the players' actions ask for it (difficulty.h), at
/// most one change a tick. The report names the change.
void follow_players(ZoneState& state);

/// An entity that something is done to must be simulated: wakes its agent where it has one that
/// goes from event to event.
void wake_agent(ZoneState& state, world::Row row);

}  // namespace zoned::zone
