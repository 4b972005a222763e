// Quiet: how long nothing can change for a mind that nobody sees.
#pragma once

#include "server/ai/decision.h"

namespace zoned::ai {

/// What a forecast needs to know besides the mind.
struct Outlook {
    float speed = 0.0F;  ///< of its entity, m/s
    float day_s = 0.0F;
    float dt = 0.0F;  ///< s
};

/// No decision of the mind before the tick returned (> `now`) takes a transition, begins or ends a
/// hold, or chooses another deed than the one at `now`, as long as it perceives nobody and none of
/// its variables is changed from outside: no condition of its state, tree or plan becomes other
/// than `senses` (those of `now`) say. A distance changes at most by the way that is walked, a
/// variable grows at its rate, time passes; what cannot be told in advance (fuzzy outputs of what
/// changes) may change at once. Random numbers are known in advance: they are looked at for
/// a number of decisions.
///
/// So between two such ticks nothing needs to be computed, and what happens at them is exactly what
/// would have happened (next-event time progression; Law, "Simulation Modeling and Analysis", 5th
/// ed. 2015, section 1.3.1).
Tick quiet_until(const Mind& mind,
                 const CompiledMachine& machine,
                 const Senses& senses,
                 const Outlook& outlook,
                 Tick now);

}  // namespace zoned::ai
