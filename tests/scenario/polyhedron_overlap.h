// PolyhedronOverlap: overlap of polyhedra, and of solids with a surface, in double precision.
#pragma once

#include "tests/scenario/solid_geometry.h"

namespace zoned::scenario {

/// The least translation that parts two polyhedra, `b` given in the axes of `a`; 0 where they do
/// not overlap. Looks along the normals of their Minkowski difference: faces, and pairs of edges
/// whose arcs cross on the Gauss map (Gregory, "The Separating Axis Test between Convex
/// Polyhedra", GDC 2013).
double polyhedra_overlap(const SolidGeometry& a, const SolidGeometry& b, const Pose& b_in_a);

/// Least signed distance of the segment centre +- half to a polyhedron: negative inside, where it
/// is that of the deepest point of the segment.
double least_distance(const SolidGeometry& hull, const Vec3d& centre, const Vec3d& half);

/// How far a convex solid in front of a surface reaches behind one of its triangles.
double depth_behind(const SolidGeometry& surface,
                    const Pose& at_surface,
                    const Solid& solid,
                    const Pose& at);

}  // namespace zoned::scenario
