#include "server/physics/narrowphase/collide.h"

#include <algorithm>
#include <cmath>

namespace zoned::physics {

void collide_balls(const Vec3& pa,
                   float ra,
                   const Vec3& pb,
                   float rb,
                   std::uint32_t feature,
                   float margin,
                   Manifold& out) {
    const Vec3 d = pb - pa;
    const float distance = d.norm();
    out.normal = distance > 1.0e-9F ? Vec3(d / distance) : Vec3(Vec3::UnitY());
    out.separation = distance - ra - rb;
    if (out.separation <= margin) {
        const Vec3 on_a = pa + ra * out.normal;
        const Vec3 on_b = pb - rb * out.normal;
        out.add(0.5F * (on_a + on_b), out.separation, feature);
    }
}

void collide_sphere_sphere(const Placed& a, const Placed& b, float margin, Manifold& out) {
    collide_balls(a.position, a.shape.radius, b.position, b.shape.radius, 0, margin, out);
}

void collide_sphere_capsule(const Placed& a, const Placed& b, float margin, Manifold& out) {
    const Vec3 axis = b.rotation.col(1);
    const float h = b.shape.half_segment;
    const float t = std::clamp(axis.dot(a.position - b.position), -h, h);
    collide_balls(
        a.position, a.shape.radius, b.position + t * axis, b.shape.radius, 0, margin, out);
}

void collide_sphere_box(const Placed& a, const Placed& b, float margin, Manifold& out) {
    const Vec3& half = b.shape.half_extents;
    const Vec3 centre = b.to_local(a.position);
    const Vec3 nearest = centre.cwiseMax(-half).cwiseMin(half);
    const Vec3 gap = nearest - centre;
    const float distance = gap.norm();
    const float r = a.shape.radius;
    Vec3 normal = Vec3::Zero();  // local, from the sphere to the box
    Vec3 surface = nearest;
    if (distance > 1.0e-6F) {
        normal = gap / distance;
        out.separation = distance - r;
    } else {
        // The centre is inside: out through the nearest face.
        int axis = 0;
        const Vec3 depth = half - centre.cwiseAbs();
        depth.minCoeff(&axis);
        const float side = centre[axis] >= 0.0F ? 1.0F : -1.0F;
        normal[axis] = -side;
        surface[axis] = side * half[axis];
        out.separation = -depth[axis] - r;
    }
    out.normal = b.rotation * normal;
    if (out.separation <= margin) {
        const Vec3 on_sphere = centre + r * normal;
        out.add(b.to_world(0.5F * (on_sphere + surface)), out.separation, 0);
    }
}

}  // namespace zoned::physics
