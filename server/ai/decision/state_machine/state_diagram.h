// State diagram: dot_of() writes a state machine as text for Graphviz.
#pragma once

#include "server/ai/decision/state_machine/state_machine_def.h"

#include <span>
#include <string>

namespace zoned::ai::state_machine {

/// A graph in the language of `dot`: states are boxes, and transitions are arrows with all their
/// conditions. A state with inner states is a frame around them. Its tab stands for the state as a
/// whole, and is marked H or H* for a shallow or deep history. Dashed arrows lead to the first
/// states. Transitions by code are unknown here. `senses`: the names of the senses in conditions.
std::string dot_of(const StateMachineDef& def, std::span<const std::string> senses);

}  // namespace zoned::ai::state_machine
