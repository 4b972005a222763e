// Behaviours: a type that is a set of behaviours, each a brain with parameters, gets one brain
// made of them.
#pragma once

#include "server/config/text/diagnostics.h"

#include <string>
#include <vector>

namespace zoned::proto::config {
class Config;
}  // namespace zoned::proto::config

namespace zoned::config {

struct ParameterChoice;

/// Makes types complete (type_families.h), and for each that has behaviours a brain "TYPE.brain":
/// its states are the behaviours, with the type's numbers in the place of parameters. Precedence is
/// order, as in layers of which a higher one takes over from those below it (Brooks, "A robust
/// layered control system for a mobile robot", IEEE Journal of Robotics and Automation 2, 1986,
/// section III): whatever is active, the first behaviour before it of which a cue holds takes over;
/// where it ends, the first after it of which a cue holds goes on, and the last one where none
/// does. All that is decided here: in the server such an agent is a brain like any other.
/// Machines, trees and domains that take parameters are copied for each type
/// ("TYPE.BEHAVIOUR.NAME").
///
/// An agent has the variables of all of its behaviours' brains, perceives as far as the farthest
/// and decides as often as the most frequent of them.
///
/// Reports, at the place in the file: behaviours and parameters that are none, parameters that no
/// setting takes or whose bounds it does not bear, behaviours that never begin or never end,
/// variables of one name that differ. Returns what all parameters are.
std::vector<ParameterChoice> build_behaviours(proto::config::Config& config,
                                              Diagnostics& diagnostics);

}  // namespace zoned::config
