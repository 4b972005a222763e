// Hull faces: joins the coplanar triangles of a hull to polygons.
#pragma once

#include "server/physics/shapes/convex/quickhull.h"

#include <span>
#include <vector>

namespace zoned::physics {

/// Corners of each face counter-clockwise seen from outside, as indices of points. Every edge is
/// shared by two faces that run along it in opposite directions.
using FaceLoops = std::vector<std::vector<int>>;

/// Joins triangles whose corners all lie within `tolerance` metres of the plane of the largest of
/// them, and drops the corners that then lie within an edge or a face. Where the joined faces would
/// not make up a closed surface of convex polygons, all triangles stay as they are.
FaceLoops merge_faces(std::span<const Vec3d> points, const TriangleHull& hull, double tolerance);

}  // namespace zoned::physics
