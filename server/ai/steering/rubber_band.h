// Rubber band: the speed of a chase, a flight or a race follows the distance to the player.
#pragma once

#include "server/ai/steering/desired_velocity.h"

namespace zoned::ai {

/// Updates agent.band from the distance to its prey, once per tick that steers. A chaser becomes
/// faster the farther off its prey is; an agent that flees becomes slower. A follower of a track
/// goes by the distance along the track (learning::gap_on_track()), for players who drive on it.
/// The band is 1 in states without one, and goes back to 1 where there is no prey. Allocates
/// nothing.
///
/// Where the band asks for rivals, those nearest to the player are counted: entities of the agent's
/// type, as the crow flies, those of neighbour zones included as far as a zone sees. Ties go by
/// entity.
void follow_band(Agent& agent, const BrainState& state, const Surroundings& around);

}  // namespace zoned::ai
