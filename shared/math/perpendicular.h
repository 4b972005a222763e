// perpendicular: a unit vector across another one.
#pragma once

#include "shared/math/types.h"

namespace zoned {

/// Some unit vector across `n`, which is a unit vector of floats or doubles; always the same one.
template <class Vector>
Vector any_perpendicular(const Vector& n) {
    // Crossing with the axis of the smallest component keeps the result long.
    int axis = 0;
    n.cwiseAbs().minCoeff(&axis);
    return n.cross(Vector::Unit(axis)).normalized();
}

}  // namespace zoned
