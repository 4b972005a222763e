// Level of detail of minds: those that no player is near steer less often.
#pragma once

#include "server/ai/ai_step.h"

namespace zoned::ai {

inline constexpr Tick kFarPeriod = 4;  ///< far minds steer every so many ticks

/// Far minds take turns by entity id, so that the load is even over ticks. A state that was just
/// entered begins at once, so that no command is ever repeated into it.
inline bool steers_now(const Mind& mind, const Settings& settings, Tick now) {
    return !settings.reduce_far || !mind.far || mind.entered ||
           (now + static_cast<Tick>(mind.entity.value)) % kFarPeriod == 0;
}

}  // namespace zoned::ai
