// Math calls: finds calls of functions whose last bits depend on the C library or on Eigen's
// vectors, in code whose results have to be the same on all computers.
#pragma once

#include "tests/lint/check.h"

#include <vector>

namespace zoned::lint {

/// Sines, logarithms and the like come from shared/core/elementary, in all of the product but for
/// pages that people look at. Roots, roundings and remainders are exact everywhere.
std::vector<Finding> check_math_calls(const SourceFile& file);

}  // namespace zoned::lint
