// Narrowphase: picks the pair test, and looks ahead along the path of fast pairs.
#pragma once

#include "server/physics/narrowphase/collide.h"
#include "server/physics/narrowphase/contact_set.h"

namespace zoned::physics {

/// Points farther apart than this are no contacts, unless the pair closes the gap within the step.
inline constexpr float kContactMargin = 0.02F;
/// Surfaces closer than this touch, m.
inline constexpr float kTouch = 0.005F;

/// Contact of two placed convex shapes with points up to `margin` metres apart, normal from a to b.
/// Two planes have no contact. `out` is overwritten.
void collide(const Placed& a, const Placed& b, float margin, Manifold& out);

/// How a pair moves in the coming step.
struct PairMotion {
    Vec3 velocity_a = Vec3::Zero();  ///< m/s
    Vec3 velocity_b = Vec3::Zero();
    float turn = 0.0F;  ///< how far rotation may carry surface points within the step, m
    float dt = 0.0F;    ///< s
};

/// When a pair was looked at.
struct Impact {
    float time = 0.0F;    ///< s from now
    float margin = 0.0F;  ///< points up to this gap were looked for, m
};

/// The first contact of the pair within the step. A slow pair is tested where it stands. A fast one
/// is advanced along its relative velocity to its time of impact (conservative advancement:
/// Mirtich, PhD thesis, Berkeley 1996). So the normal and the points are those of the impact. Those
/// of a far-off approach would make things bounce off empty space. The manifold holds separations
/// and points at that time.
Impact collide_ahead(const Placed& a, const Placed& b, const PairMotion& motion, Manifold& out);

/// The same for pairs of which at least one is not convex: all manifolds of the time of the first
/// impact.
Impact collide_ahead(const Placed& a, const Placed& b, const PairMotion& motion, ContactSet& out);

}  // namespace zoned::physics
