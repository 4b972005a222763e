// Steering: turns an agent's action into a command that stays constant as long as it can.
#pragma once

#include "server/ai/steering/desired_velocity.h"

namespace zoned::ai {

/// A far agent steers at least once in this many ticks.
inline constexpr Tick kFarPeriod = 4;
/// An agent without progress for this long is blocked, s.
inline constexpr float kPatienceS = 2.0F;

/// Updates agent.aim. Every change of direction costs a publication for each level of detail, so
/// small errors of the heading are kept. The allowed error is a few degrees at the tick of a
/// decision and more in between. Standing still is exactly zero. True: it needs a path first, see
/// plan_segment().
bool steer(Agent& agent, const CompiledBrain& brain, const Surroundings& around);

/// The next steering tick of a far agent after `now`. It comes every few ticks; the entity id
/// spreads the load over ticks. The agent also steers when its goal is reached, because late turns
/// would add up.
Tick next_turn(const Agent& agent, Tick now);

/// A herd animal without progress for kPatienceS walks across its path for a while
/// (agent.detour_until).
void get_unstuck(Agent& agent, const BrainState& state, const Surroundings& around);

}  // namespace zoned::ai
