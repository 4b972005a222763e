// Gate guard: a sample of a state machine in code, as a switch and as an object a state. The
// machine as data, and the actions of its states, are in config/methods/ai_code.txtpb.
#pragma once

#include "server/ai/decision/state_machine/coded_state_machine.h"

namespace zoned::rules {

/// "gate_guard", a switch, and "gate_guard_states", an object a state; they decide alike. Agents
/// need a variable `breath`.
ai::state_machine::CodedMachines gate_guards();

}  // namespace zoned::rules
