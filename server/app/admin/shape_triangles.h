// Shape triangles: the surface of a rigid shape as triangles, for drawing.
#pragma once

#include "server/physics/shapes/shape.h"

#include <vector>

namespace zoned::app {

/// Three corners each, counter-clockwise seen from outside, in the shape's own axes, m. Round
/// shapes are a coarse polyhedron. Empty for planes and static surfaces.
[[nodiscard]] std::vector<Vec3> triangles_of(const physics::Shape& shape);

}  // namespace zoned::app
