// Counts the allocations of a test program: "no allocation after warm-up" needs a witness.
#pragma once

#include <cstdint>

namespace zoned::testing_support {

/// Calls of operator new so far.
std::uint64_t allocations();

}  // namespace zoned::testing_support
