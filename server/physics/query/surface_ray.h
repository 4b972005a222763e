// Surface ray: casts rays against surfaces and compounds.
#pragma once

#include "server/physics/shapes/compound/compound.h"
#include "server/physics/shapes/heightfield.h"
#include "server/physics/shapes/mesh.h"

namespace zoned::physics {

/// First front of a triangle along origin + t direction (unit), 0 <= t <= limit, all in the frame
/// of the surface. Backs are not hit. Fills t and the unit normal.
bool cast_mesh(const TriangleMesh& mesh,
               const Vec3& origin,
               const Vec3& direction,
               float limit,
               float& t,
               Vec3& normal);

/// The same by a walk over the cells that the ray passes (Amanatides and Woo, "A fast voxel
/// traversal algorithm for ray tracing", Eurographics 1987).
bool cast_heightfield(const Heightfield& field,
                      const Vec3& origin,
                      const Vec3& direction,
                      float limit,
                      float& t,
                      Vec3& normal);

/// The nearest hit of any part that is no sensor.
bool cast_compound(const Compound& compound,
                   const Vec3& origin,
                   const Vec3& direction,
                   float limit,
                   float& t,
                   Vec3& normal);

}  // namespace zoned::physics
