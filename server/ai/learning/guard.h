// Guard: an envelope of movement that no policy can leave, whatever its outputs.
#pragma once

#include "server/ai/learning/policy.h"
#include "shared/motion/apply_input.h"

#include <cstdint>

namespace zoned::ai::learning {

struct Guard {
    float max_speed = 1.0F;       ///< share of full speed, [0, 1]
    float max_turn_radps = 6.0F;  ///< fastest turn, > 0
    float max_home_m = 0.0F;      ///< greatest distance from home, m; 0: no limit
    bool may_sprint = false;
};

/// Guarded: the state of the guarded agent that the guard needs.
struct Guarded {
    Vec2 from_home = Vec2::Zero();  ///< its position relative to home, m
    Vec2 velocity = Vec2::Zero();   ///< m/s
    std::uint16_t yaw = 0;          ///< yaw of its command before this one
    float dt = 0.0F;                ///< time for which it may turn now, s
    float horizon_s = 0.0F;         ///< the guard is asked again within this, >= dt
};

/// The command nearest to the wanted one inside the envelope; its tick is not used.
/// - `move` has a length of at most max_speed (of 127, rounded towards 0) and always the direction
///   of its yaw. The yaw is at most max_turn_radps * dt away from the one before.
/// - It sprints where it may, and never presses another button.
/// - An agent that obeys and is not pushed stays within max_home_m of home. It turns on the spot
///   and goes home as soon as there is a risk of leaving. There is a risk when going on for
///   `horizon_s` and then turning back might lead out. The path needed for that is s h + s^2 / a
///   with speed s and acceleration a. Braking alone takes half of the second term. Changing
///   straight to a path that leads home at 60 degrees or less takes two thirds. An agent outside
///   goes home.
/// - An input that is not a number gives a command to stand.
motion::InputCommand guarded(const Guard& guard,
                             const Wanted& wanted,
                             const Guarded& body,
                             const motion::CharacterLimits& limits);

}  // namespace zoned::ai::learning
