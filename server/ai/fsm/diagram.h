// Diagram: a state machine as text for Graphviz.
#pragma once

#include "server/ai/fsm/machine_def.h"

#include <span>
#include <string>

namespace zoned::ai::fsm {

/// A graph in the language of `dot`: states as boxes, machines as states as frames around theirs,
/// transitions as arrows with all their conditions. An arrow that begins or ends at a frame means
/// the state with all that is inside; a dot leads to where a machine begins, H and H* stand for
/// shallow and deep histories. `senses`: names of what conditions read.
std::string dot_of(const MachineDef& def, std::span<const std::string> senses);

}  // namespace zoned::ai::fsm
