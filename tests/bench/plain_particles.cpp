// build: hot loops
#include "tests/bench/plain_particles.h"

namespace zoned::bench {

void plain_particle_loop(std::size_t count,
                         float h,
                         float gx,
                         float gy,
                         float gz,
                         float* __restrict x,
                         float* __restrict y,
                         float* __restrict z,
                         float* __restrict vx,
                         float* __restrict vy,
                         float* __restrict vz) {
    for (std::size_t i = 0; i < count; ++i) {
        vx[i] += h * gx;
        vy[i] += h * gy;
        vz[i] += h * gz;
        x[i] += h * vx[i];
        y[i] += h * vy[i];
        z[i] += h * vz[i];
    }
}

}  // namespace zoned::bench
