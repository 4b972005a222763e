// The sentry's state machine written as code, as a switch and as a class per state.
#pragma once

#include "server/ai/decision/state_machine/active_state.h"

#include <span>

namespace zoned::bench {

/// One decision of an agent; true where it left its state.
bool sentry_by_switch(ai::state_machine::ActiveState& state,
                      std::span<const float> senses,
                      Tick now);

bool sentry_by_class(ai::state_machine::ActiveState& state,
                     std::span<const float> senses,
                     Tick now);

}  // namespace zoned::bench
