// Shape ray: casts rays against single shapes.
#pragma once

#include "server/physics/narrowphase/collide.h"

namespace zoned::physics {

/// First point of the shape along origin + t direction (unit), 0 <= t <= limit. A ray that starts
/// inside hits at t = 0 with the normal against its direction. Fills t and the outward unit normal.
bool cast_ray(const Placed& shape,
              const Vec3& origin,
              const Vec3& direction,
              float limit,
              float& t,
              Vec3& normal);

}  // namespace zoned::physics
