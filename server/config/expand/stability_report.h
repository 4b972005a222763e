// Stability report: what in a good config the physics cannot simulate within the error budget.
#pragma once

#include <string>
#include <vector>

namespace zoned::config {

struct Settings;

/// One sentence each, with the setting that it is about and the figures; empty when there is
/// nothing to say. Looks at the step itself, each type's body, the heaviest prop on the lightest
/// one, how far out each zone reaches (see physics::stability_warnings_of), and each surface
/// from a file (see geometry_survey.h).
std::vector<std::string> stability_warnings_of(const Settings& settings);

}  // namespace zoned::config
