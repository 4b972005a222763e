// Policy steering: steers an agent by a learned policy.
#pragma once

#include "server/ai/steering/steering.h"

namespace zoned::ai {

/// The policy's view of its agent; the target is the agent's prey.
learning::Situation situation_of(const Agent& agent, const Surroundings& around);

/// Updates agent.aim by the choice's policy. Its full output means full speed times the state's
/// factor (and band). The guard is asked at every tick that steers, also for a far agent, so the
/// command stays within it for kFarPeriod ticks. Changes too small to notify others are left out.
/// Allocates nothing.
void steer_by_policy(Agent& agent,
                     const CompiledBrain& brain,
                     const BrainState& state,
                     const PolicyChoice& choice,
                     const Surroundings& around);

}  // namespace zoned::ai
