// Restitution: the speed at which bodies part after a bounce within a substep.
#pragma once

#include <algorithm>
#include <cmath>

namespace zoned::physics {

/// A body that falls onto another at w, s above it, under the relative acceleration `pull` along
/// the normal, meets it at v^2 = w^2 - 2 pull s and leaves at e v. It is at s + h u when the
/// substep ends. The speed with the right energy there is u^2 = (e v)^2 + 2 pull (s + h u).
inline double bounce_speed(double w, double gap, double pull, double e, double h) {
    const double met2 = std::max(0.0, w * w - 2.0 * pull * gap);
    const double square = pull * h * pull * h + e * e * met2 + 2.0 * pull * gap;
    return std::max(0.0, pull * h + std::sqrt(std::max(0.0, square)));
}

}  // namespace zoned::physics
