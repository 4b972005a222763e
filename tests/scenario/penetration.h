// Penetration: the exact overlap of two solids in double precision; judges engines, uses none.
#pragma once

#include "tests/scenario/physics_scenes.h"

namespace zoned::scenario {

/// The least translation that parts two placed solids, metres; 0 where they do not overlap. Pairs
/// of boxes use all separating axes (Gottschalk, Lin, Manocha, "OBBTree", SIGGRAPH 1996). For
/// convex polytopes the axes of faces and edge pairs are the normals of their Minkowski difference,
/// so the least overlap is the exact depth. Spheres and capsules use the distance of their cores,
/// points and segments, less the radii. Of compounds the deepest pair of parts counts. A mesh is
/// entered by corners that lie behind a triangle and by balls that reach behind one; edges that
/// cross between corners are not seen.
double penetration(const Solid& a, const Pose& at_a, const Solid& b, const Pose& at_b);

/// How far the solid's lowest point is below y = 0, metres; 0 where it is not.
double depth_below_ground(const Solid& solid, const Pose& pose);

/// Radius of the sphere about the centre that holds the solid, m.
double bounding_radius(const Solid& solid);

}  // namespace zoned::scenario
