// Whereabouts: where an agent takes itself to be.
#pragma once

#include "server/ai/agent/agent.h"

namespace zoned::ai {

/// Whose body is farther than this from where its segment says was pushed or held up, m: the
/// segment is made anew from where it is.
inline constexpr float kDriftM = 1.0F;

/// Whether the agent goes by its segment, and its body, which is at `body` (x, z, m), has not gone
/// astray.
bool keeps_to_segment(const Agent& agent, const Vec2& body, Tick now, float dt);

/// Where an agent takes itself to be, x, z at the end of the last tick: where its segment says,
/// unless its body, which is at `body`, has gone astray. What it senses of itself follows from this
/// alone, so that it decides alike whether its body is simulated or not.
Vec2 whereabouts(const Agent& agent, const Vec2& body, Tick now, float dt);

}  // namespace zoned::ai
