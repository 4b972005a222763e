// RandomVector: random vectors for the tests of motion.
#pragma once

#include "shared/core/rng.h"
#include "shared/math/types.h"

namespace zoned {

/// Each component within +-size.
inline Vec3 random_vector(core::Rng& rng, float size) {
    const float x = rng.range(-size, size);
    const float y = rng.range(-size, size);
    return {x, y, rng.range(-size, size)};
}

}  // namespace zoned
