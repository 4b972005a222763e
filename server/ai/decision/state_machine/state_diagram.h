// Diagram: a state machine as text for Graphviz.
#pragma once

#include "server/ai/decision/state_machine/state_machine_def.h"

#include <span>
#include <string>

namespace zoned::ai::state_machine {

/// A graph in the language of `dot`: states as boxes, transitions as arrows with all their
/// conditions. A machine as a state is a frame around its states with a tab that stands for the
/// state as a whole, marked H or H* for a shallow or deep history; dashed arrows lead to where
/// machines begin. `senses`: names of what conditions read.
std::string dot_of(const StateMachineDef& def, std::span<const std::string> senses);

}  // namespace zoned::ai::state_machine
