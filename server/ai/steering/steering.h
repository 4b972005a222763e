// Steering: turns the action of an agent's state into a command that stays constant as long as it
// can.
#pragma once

#include "server/ai/steering/desired_velocity.h"

namespace zoned::ai {

/// Where it is far an agent steers at least every so many ticks.
inline constexpr Tick kFarPeriod = 4;
/// No progress for so long means that something is in the way, s.
inline constexpr float kPatienceS = 2.0F;

/// Updates agent.aim. Every change of direction costs a publication for each level of detail, so
/// the heading is corrected only when it is off by some degrees: few at the tick of a decision,
/// more in between. Standing still is exactly zero. True: it needs a path first, see
/// plan_segment().
bool steer(Agent& agent, const CompiledBrain& brain, const Surroundings& around);

/// The next turn after `now` of one that is far: every few ticks, by entity id so that the load is
/// even over ticks. It steers as well when its goal is reached: late turns would add up.
Tick next_turn(const Agent& agent, Tick now);

/// One of a herd that makes no progress for kPatienceS walks across its path for a while
/// (agent.detour_until).
void get_unstuck(Agent& agent, const BrainState& state, const Surroundings& around);

}  // namespace zoned::ai
