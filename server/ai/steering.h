// Steering: turns the action of a mind's state into a command that stays constant as long as it
// can.
#pragma once

#include "server/ai/ai_step.h"

namespace zoned::ai {

/// A goal this near counts as reached, m.
inline constexpr float kArriveM = 1.0F;
/// A chaser stops this near to its prey and follows again beyond the other, m.
inline constexpr float kChaseStopM = 1.1F;
inline constexpr float kChaseFollowM = 1.4F;
/// No progress for so long means that something is in the way, s.
inline constexpr float kPatienceS = 2.0F;

/// What steering reads besides the mind.
struct Surroundings {
    const world::Entities& entities;
    const world::TypeTable& types;
    const spatial::PointGrid& grid;
    world::Row self;
    Tick now;
    float dt;  ///< s
};

/// Updates mind.aim. Every change of direction costs a publication for each level of detail, so the
/// heading is corrected only when it is off by some degrees: few at the tick of a decision, more in
/// between. Standing still is exactly zero.
void steer(Mind& mind, const CompiledMachine& machine, const Surroundings& around);

}  // namespace zoned::ai
