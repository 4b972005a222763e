// PlainSentry: the sentry's state machine written as code, as a switch and as a class per state.
#pragma once

#include "server/ai/decision/state_machine/active_states.h"

namespace zoned::bench {

/// One decision of every agent, as server/ai/fsm does it from tables.
void sentry_by_switch(ai::state_machine::ActiveStates& states,
                      const ai::SenseColumns& senses,
                      Tick now,
                      std::vector<ai::state_machine::StateChange>& changes);

void sentry_by_class(ai::state_machine::ActiveStates& states,
                     const ai::SenseColumns& senses,
                     Tick now,
                     std::vector<ai::state_machine::StateChange>& changes);

}  // namespace zoned::bench
