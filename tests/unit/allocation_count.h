// AllocationCount: counts calls of operator new, to prove "no allocation after warm-up".
#pragma once

#include <cstdint>

namespace zoned {

/// Calls of any form of operator new so far, from all threads.
std::uint64_t allocation_count();

}  // namespace zoned
