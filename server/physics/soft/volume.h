// Volume: the volumes of tetrahedra and closed surfaces, and their gradients at the nodes.
#pragma once

#include "server/physics/soft/soft_def.h"

#include <array>

namespace zoned::physics::soft {

/// Signed, m3; positive where d sees a, b, c turn counter-clockwise from the side away from d.
inline float tetrahedron_volume(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d) {
    return (b - a).cross(c - a).dot(d - a) / 6.0F;
}

/// Derivatives of the volume by its corners, m2.
inline std::array<Vec3d, 4> tetrahedron_gradient(const Vec3d& a,
                                                 const Vec3d& b,
                                                 const Vec3d& c,
                                                 const Vec3d& d) {
    const Vec3d gb = (c - a).cross(d - a) / 6.0;
    const Vec3d gc = (d - a).cross(b - a) / 6.0;
    const Vec3d gd = (b - a).cross(c - a) / 6.0;
    return {-gb - gc - gd, gb, gc, gd};
}

}  // namespace zoned::physics::soft
