// Collide: the pair tests of the narrowphase, one function per pair of shapes with one signature.
#pragma once

#include "server/physics/narrowphase/manifold.h"
#include "server/physics/shapes/shape.h"

namespace zoned::physics {

/// A shape at a pose.
struct Placed {
    const Shape& shape;
    Vec3 position;
    const Mat3& rotation;  ///< body to world

    [[nodiscard]] Vec3 to_local(const Vec3& world) const {
        return rotation.transpose() * (world - position);
    }

    [[nodiscard]] Vec3 to_world(const Vec3& local) const { return rotation * local + position; }
};

/// Takes a manifold that was found in the frame of `place` out into the world.
inline void to_world(const Placed& place, Manifold& manifold) {
    manifold.normal = place.rotation * manifold.normal;
    for (std::size_t i = 0; i < static_cast<std::size_t>(manifold.count); ++i) {
        manifold.points[i].point = place.to_world(manifold.points[i].point);
    }
}

/// Each of these fills normal and separation, and adds the points whose separation is at most
/// `margin` metres. The names say which shape is a and which is b.
void collide_sphere_sphere(const Placed& a, const Placed& b, float margin, Manifold& out);
void collide_sphere_box(const Placed& a, const Placed& b, float margin, Manifold& out);
void collide_sphere_capsule(const Placed& a, const Placed& b, float margin, Manifold& out);
void collide_sphere_plane(const Placed& a, const Placed& b, float margin, Manifold& out);
void collide_box_box(const Placed& a, const Placed& b, float margin, Manifold& out);
void collide_box_capsule(const Placed& a, const Placed& b, float margin, Manifold& out);
void collide_box_plane(const Placed& a, const Placed& b, float margin, Manifold& out);
void collide_capsule_capsule(const Placed& a, const Placed& b, float margin, Manifold& out);
void collide_capsule_plane(const Placed& a, const Placed& b, float margin, Manifold& out);
void collide_sphere_hull(const Placed& a, const Placed& b, float margin, Manifold& out);
void collide_box_hull(const Placed& a, const Placed& b, float margin, Manifold& out);
void collide_capsule_hull(const Placed& a, const Placed& b, float margin, Manifold& out);
void collide_plane_hull(const Placed& a, const Placed& b, float margin, Manifold& out);
void collide_hull_hull(const Placed& a, const Placed& b, float margin, Manifold& out);

/// A sphere of radius ra about pa against one of radius rb about pb: all round pairs reduce to
/// this. Coincident centres are parted upwards.
void collide_balls(const Vec3& pa,
                   float ra,
                   const Vec3& pb,
                   float rb,
                   std::uint32_t feature,
                   float margin,
                   Manifold& out);

}  // namespace zoned::physics
