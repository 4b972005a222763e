// Flock: agents over a square of ground, for tests and benchmarks.
#pragma once

#include "kernels/include/flock.h"
#include "shared/core/rng.h"

#include <cmath>
#include <cstddef>

namespace zoned::scenario {

/// About five agents per cell of `radius`, 45 in a cell and those around it.
inline kernels::FlockRules flock_rules(std::size_t count) {
    const float radius = 3.0F;
    const float side = radius * std::sqrt(static_cast<float>(count) / 5.0F);
    kernels::FlockRules r{};
    r.h = 1.0F / 60.0F;
    r.radius2 = radius * radius;
    r.separation2 = 1.0F;
    r.separation = 4.0F;
    r.alignment = 0.5F;
    r.cohesion = 0.3F;
    r.most_acceleration = 12.0F;
    r.least_speed = 1.0F;
    r.most_speed = 6.0F;
    r.high_x = side;
    r.high_y = 6.0F;
    r.high_z = side;
    r.turn_back = 8.0F;
    return r;
}

/// Calls put(i, x, y, z, vx, vy, vz) for agents at random in the box of the rules.
template <class Put>
void scatter_flock(std::size_t count, const kernels::FlockRules& r, Put&& put) {
    core::Rng rng(17);
    for (std::size_t i = 0; i < count; ++i) {
        const float x = rng.range(r.low_x, r.high_x);
        const float y = rng.range(r.low_y, r.high_y);
        const float z = rng.range(r.low_z, r.high_z);
        const float vx = rng.range(-3.0F, 3.0F);
        const float vy = rng.range(-1.0F, 1.0F);
        const float vz = rng.range(-3.0F, 3.0F);
        put(i, x, y, z, vx, vy, vz);
    }
}

}  // namespace zoned::scenario
