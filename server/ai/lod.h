// Level of detail of minds: those that no player is near steer only so often.
#pragma once

#include "server/ai/ai_step.h"

namespace zoned::ai {

/// A state that was just entered begins at once, so that no command is ever repeated into it.
inline bool steers_now(const Mind& mind, const Settings& settings, Tick now) {
    return !settings.reduce_far || !mind.far || mind.entered || now >= mind.next_steering;
}

}  // namespace zoned::ai
