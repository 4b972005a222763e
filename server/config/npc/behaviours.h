// behaviours: makes one brain from the behaviours of a type, each a brain with parameters.
#pragma once

#include "server/config/text/diagnostics.h"

#include <string>
#include <vector>

namespace zoned::proto::config {
class Config;
}  // namespace zoned::proto::config

namespace zoned::config {

struct ParameterChoice;

/// Completes types (type_families.h), and gives each type with behaviours a brain "TYPE.brain". Its
/// states are the behaviours, with the type's numbers in place of parameters. Order is precedence,
/// as in layers where a higher one takes over from the lower ones (Brooks, "A robust layered
/// control system for a mobile robot", IEEE Journal of Robotics and Automation 2, 1986, section
/// III): The first behaviour before the active one with a cue that holds takes over. Where the
/// active one ends, the first after it with a cue that holds goes on, or else the last. All that is
/// decided here: in the server such an agent has a brain like any other. Brains, trees and domains
/// that take parameters are copied for each type ("TYPE.BEHAVIOUR.NAME").
///
/// An agent has the variables of all of its behaviours' brains, perceives as far as the farthest,
/// and decides as often as the most frequent.
///
/// Reports, at the place in the file: unknown behaviours and parameters, parameters that no setting
/// takes, parameters with bounds outside the setting's range, behaviours that never begin or never
/// end, and variables of one name that differ. Returns the values of all parameters.
std::vector<ParameterChoice> build_behaviours(proto::config::Config& config,
                                              Diagnostics& diagnostics);

}  // namespace zoned::config
