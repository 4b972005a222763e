// Whether a body's state is made of numbers.
#pragma once

#include "server/physics/scene/scene.h"

namespace zoned::stability {

/// No part of the state is infinite or NaN.
[[nodiscard]] inline bool is_finite(const physics::BodyState& s) {
    return s.position.allFinite() && s.velocity.allFinite() && s.angular_velocity.allFinite() &&
           s.orientation.coeffs().allFinite();
}

}  // namespace zoned::stability
