// Policy steering: a network says where to go, its guard decides how far that goes; and the rubber
// band of a chase.
#pragma once

#include "server/ai/steering/steering.h"

namespace zoned::ai {

/// What a policy sees of its agent: its target is the agent's prey.
learning::Situation situation_of(const Agent& agent, const Surroundings& around);

/// Updates agent.aim by the choice's policy, at full speed times the state's factor (and band)
/// where the policy asks for all. The guard is asked at every tick that steers, those of a far
/// agent included, so the command stays within it for kFarPeriod ticks. Changes too small to tell
/// others are left out. Allocates nothing.
void steer_by_policy(Agent& agent,
                     const CompiledBrain& brain,
                     const BrainState& state,
                     const PolicyChoice& choice,
                     const Surroundings& around);

/// Moves agent.band by the distance to its prey, once per tick that steers: who chases becomes
/// faster the farther off that is, who flees slower. 1 in states without a rubber band.
void follow_band(Agent& agent, const BrainState& state, const Surroundings& around);

}  // namespace zoned::ai
