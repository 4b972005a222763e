// PlainParticles: engine-free peers of the suites `particles` and `kernels`.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace zoned::bench {

/// Semi-implicit Euler over columns in a plain loop; its arguments hold everything that it needs.
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
