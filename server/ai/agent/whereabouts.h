// Whereabouts: where an agent takes itself to be.
#pragma once

#include "server/ai/agent/agent.h"

namespace zoned::ai {

/// A body farther than this from its place on its segment was pushed or held up, m. The segment is
/// then made anew from the body.
inline constexpr float kDriftM = 1.0F;

/// Whether the agent follows its segment, and its body at `body` (x, z, m) has not gone astray.
bool keeps_to_segment(const Agent& agent, const Vec2& body, Tick now, float dt);

/// Where an agent takes itself to be, x, z at the end of the last tick. It is its place on its
/// segment, unless its body at `body` has gone astray. Its senses of itself follow from this alone.
/// So it decides alike whether its body is simulated or not.
Vec2 whereabouts(const Agent& agent, const Vec2& body, Tick now, float dt);

}  // namespace zoned::ai
