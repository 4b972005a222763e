// The peers of the suites `particles` and `kernels`: what somebody would write who has no engine.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace zoned::bench {

/// Semi-implicit Euler over columns in a plain loop, with everything that it needs in its
/// arguments.
void plain_particle_loop(std::size_t count,
                         float h,
                         float gx,
                         float gy,
                         float gz,
                         float* x,
                         float* y,
                         float* z,
                         float* vx,
                         float* vy,
                         float* vz);

}  // namespace zoned::bench
