// world_warnings: the parts of a good config that are most likely not what their author meant.
#pragma once

#include <string>
#include <vector>

namespace zoned::config {

struct Settings;

/// One sentence for each: types that no viewer hears, heightfields that end in a step within the
/// world, falls faster than the wire carries. Empty without any.
std::vector<std::string> world_warnings_of(const Settings& settings);

/// The names of the `testing` settings that are set: faults on purpose.
std::vector<std::string> testing_faults_of(const Settings& settings);

}  // namespace zoned::config
