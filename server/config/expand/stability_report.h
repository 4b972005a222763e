// stability_report: the parts of a good config that the physics cannot simulate within the error
// budget.
#pragma once

#include <string>
#include <vector>

namespace zoned::config {

struct Settings;

/// One sentence for each part, with its setting and the figures; empty without any. Looks at the
/// step itself, each type's body, the heaviest prop on the lightest one, how far out each zone
/// reaches (see physics::stability_warnings_of), and each surface from a file (see
/// geometry_survey.h).
std::vector<std::string> stability_warnings_of(const Settings& settings);

}  // namespace zoned::config
