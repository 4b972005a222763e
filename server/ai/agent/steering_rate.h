// Level of detail of agents: those that no player is near steer only so often.
#pragma once

#include "server/ai/ai_update.h"

namespace zoned::ai {

/// A state that was just entered begins at once, so that no command is ever repeated into it.
inline bool steers_now(const Agent& agent, const AiSettings& settings, Tick now) {
    return !settings.reduce_far || !agent.far || agent.entered || now >= agent.next_steering;
}

}  // namespace zoned::ai
