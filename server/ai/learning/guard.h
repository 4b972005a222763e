// Guard: an envelope that no policy can leave, whatever it answers.
#pragma once

#include "server/ai/learning/policy.h"
#include "shared/motion/apply_input.h"

#include <cstdint>

namespace zoned::ai::learning {

struct Guard {
    float max_speed = 1.0F;       ///< share of full speed, [0, 1]
    float max_turn_radps = 6.0F;  ///< how fast it may turn, > 0
    float max_home_m = 0.0F;      ///< how far from home it may go, m; 0: anywhere
    bool may_sprint = false;
};

/// What a guard must know of who it guards.
struct Guarded {
    Vec2 from_home = Vec2::Zero();  ///< where it stands, less home, m
    Vec2 velocity = Vec2::Zero();   ///< m/s
    std::uint16_t yaw = 0;          ///< of its command before this one
    float dt = 0.0F;                ///< time for which it may turn now, s
    float horizon_s = 0.0F;         ///< the guard is asked again within this, >= dt
};

/// The command nearest to what is wanted inside the envelope; its tick is not used.
/// - `move` has a length of at most max_speed (of 127, rounded towards 0) and no direction but that
///   of its yaw; the yaw is at most max_turn_radps * dt away from the one before.
/// - Sprint where it may, no other button ever.
/// - Who obeys and is not pushed stays within max_home_m of home: as soon as going on for
///   `horizon_s` and then turning back might lead out, it turns on the spot and goes home. The way
///   needed for that is s h + s^2 / a with speed s and acceleration a: braking alone takes half of
///   the second term, changing straight to a way that leads home at 60 degrees or less two thirds.
///   Who stands outside goes home.
/// - What is no number stands.
motion::InputCommand guarded(const Guard& guard,
                             const Wanted& wanted,
                             const Guarded& body,
                             const motion::CharacterLimits& limits);

}  // namespace zoned::ai::learning
