// How often a test program has called operator new: "no allocation after warm-up" needs a witness.
#pragma once

#include <cstdint>

namespace zoned {

/// Calls of any form of operator new so far, from all threads.
std::uint64_t allocation_count();

}  // namespace zoned
