// How often the test program has called operator new.
#pragma once

#include <cstdint>

namespace zoned::physics {

std::uint64_t allocation_count();

}  // namespace zoned::physics
