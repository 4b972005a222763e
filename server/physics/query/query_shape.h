// Shape query: a convex shape against any body shape: first hit along its path, overlap, distance.
#pragma once

#include "server/physics/query/query_core.h"
#include "shared/math/aabb.h"

namespace zoned::physics {

/// A convex shape made ready for the test of many bodies.
struct QueryShape {
    explicit QueryShape(const Placed& shape);
    explicit QueryShape(const Vec3& point);

    Vec3 position;
    ConvexCore core;
    ConvexCore inner;     ///< kGraze smaller
    Aabb bounds;          ///< tight
    float radius = 0.0F;  ///< of its bounding sphere about `position`, m
};

/// First touch of a shape, moved along `direction` (unit), with a body's shape, within `limit`
/// metres. Sensor parts of compounds are passed by.
bool cast_query_shape(const QueryShape& asker,
                      const Vec3& direction,
                      float limit,
                      const Placed& body,
                      CastHit& hit);

/// Whether a shape and that of a body have a point in common. Half-spaces and the ground under
/// heightfields (as far down as their lowest point) are solid, meshes are surfaces.
bool overlaps(const QueryShape& asker, const Placed& body);

/// Fills the distance to a body's shape, its nearest point and the normal there; false when it is
/// farther than `limit`. Zero where they overlap.
bool nearest(const QueryShape& asker, float limit, const Placed& body, CastHit& hit);

}  // namespace zoned::physics
