// Decision: one pass through the transitions of a mind's state.
#pragma once

#include "server/ai/ai_step.h"
#include "server/ai/perception.h"

namespace zoned::ai {

/// Reads the sensors and takes the first transition whose condition has held for its hold_s. One
/// held transition is remembered: the first in order whose condition is true; transitions without
/// a hold fire at once, wherever they stand. Draws one random number. `position` zone-local, m;
/// `dt` in s. Returns whether the state changed.
bool decide(Mind& mind,
            const Machine& machine,
            const Sight& sight,
            const Vec3& position,
            Tick now,
            float dt);

/// Ticks between decisions, >= 1.
Tick decision_period(const Machine& machine, float dt);

/// The next tick after `now` at which the mind decides: entities are spread over the period by id,
/// so that a herd that was born in one tick does not decide in one tick for ever.
Tick next_decision(EntityId entity, Tick period, Tick now);

}  // namespace zoned::ai
