#include "server/physics/narrowphase/collide.h"

#include <cmath>

namespace zoned::physics {

namespace {

/// Adds a point of body a's surface that lies `gap` above the plane.
void add_above(const Vec3& surface,
               const Vec3& up,
               float gap,
               std::uint32_t feature,
               float margin,
               Manifold& out) {
    out.separation = std::min(out.separation, gap);
    if (gap <= margin) {
        out.add(surface - 0.5F * gap * up, gap, feature);
    }
}

}  // namespace

void collide_sphere_plane(const Placed& a, const Placed& b, float margin, Manifold& out) {
    const Vec3 up = b.rotation.col(1);
    out.normal = -up;
    out.separation = INFINITY;
    const float gap = up.dot(a.position - b.position) - a.shape.radius;
    add_above(a.position - a.shape.radius * up, up, gap, 0, margin, out);
}

void collide_capsule_plane(const Placed& a, const Placed& b, float margin, Manifold& out) {
    const Vec3 up = b.rotation.col(1);
    out.normal = -up;
    out.separation = INFINITY;
    std::uint32_t feature = 0;
    for (const float end : {-a.shape.half_segment, a.shape.half_segment}) {
        const Vec3 centre = a.position + end * a.rotation.col(1);
        const float gap = up.dot(centre - b.position) - a.shape.radius;
        add_above(centre - a.shape.radius * up, up, gap, feature++, margin, out);
    }
}

void collide_box_plane(const Placed& a, const Placed& b, float margin, Manifold& out) {
    const Vec3 up = b.rotation.col(1);
    out.normal = -up;
    out.separation = INFINITY;
    // The face that looks most against the plane's normal holds the lowest corner, and all four of
    // the corners that can carry the box at once.
    const Vec3 local_up = a.rotation.transpose() * up;
    int axis = 0;
    local_up.cwiseAbs().maxCoeff(&axis);
    const int u = (axis + 1) % 3;
    const int v = (axis + 2) % 3;
    const Vec3& half = a.shape.half_extents;
    Vec3 corner = Vec3::Zero();
    corner[axis] = local_up[axis] > 0.0F ? -half[axis] : half[axis];
    std::uint32_t feature = static_cast<std::uint32_t>(axis) << 3;
    feature |= local_up[axis] > 0.0F ? 4U : 0U;
    for (const float su : {-1.0F, 1.0F}) {
        for (const float sv : {-1.0F, 1.0F}) {
            corner[u] = su * half[u];
            corner[v] = sv * half[v];
            const Vec3 world = a.to_world(corner);
            add_above(world, up, up.dot(world - b.position), feature++, margin, out);
        }
    }
}

}  // namespace zoned::physics
