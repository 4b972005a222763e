// Polyhedra with flat faces against each other and against planes.
#include "server/physics/narrowphase/collide.h"
#include "server/physics/narrowphase/hull_clip.h"
#include "server/physics/shapes/convex/hull.h"

#include <algorithm>
#include <cmath>

namespace zoned::physics {

namespace {

/// The contact of two polyhedra, found in a's frame.
void collide_views(const HullView& a,
                   const HullView& b_local,
                   const Placed& place_a,
                   const Placed& place_b,
                   float scale,
                   float margin,
                   Manifold& out) {
    const Mat3 turn = place_a.rotation.transpose() * place_b.rotation;
    const MovedHull moved(b_local, turn, place_a.to_local(place_b.position));
    const HullView b = moved.view();
    const HullAxes axes = find_axes(a, b, margin, scale);
    const HullAxis& axis = axes.best(scale);
    out.normal = axis.normal;
    out.separation = axis.separation;
    if (axis.separation <= margin) {
        add_points(a, b, axis, margin, out);
        if (out.count == 0 && axes.edges.separation > axis.separation) {
            // The face won by its bias alone, and no part of the other hull lies over it.
            out.normal = axes.edges.normal;
            out.separation = axes.edges.separation;
            if (axes.edges.separation <= margin) {
                add_points(a, b, axes.edges, margin, out);
            }
        }
    }
    to_world(place_a, out);
}

}  // namespace

void collide_hull_hull(const Placed& a, const Placed& b, float margin, Manifold& out) {
    const ConvexHull& ha = hull_of(a.shape);
    const ConvexHull& hb = hull_of(b.shape);
    const float scale = bias_scale(std::min(ha.radius(), hb.radius()));
    collide_views(ha.view(), hb.view(), a, b, scale, margin, out);
}

void collide_box_hull(const Placed& a, const Placed& b, float margin, Manifold& out) {
    const BoxHull box(a.shape.half_extents);
    const ConvexHull& hull = hull_of(b.shape);
    const float scale = bias_scale(std::min(a.shape.half_extents.norm(), hull.radius()));
    collide_views(box.view(), hull.view(), a, b, scale, margin, out);
}

void collide_plane_hull(const Placed& a, const Placed& b, float margin, Manifold& out) {
    const Vec3 up = a.rotation.col(1);
    const PointsView points = hull_of(b.shape).view().points;
    const int corners = hull_of(b.shape).vertex_count();
    const Vec3 local_up = b.rotation.transpose() * up;
    const float height = up.dot(b.position - a.position);
    out.normal = up;
    out.separation = height + lowest(points, local_up);
    if (out.separation > margin) {
        return;
    }
    std::array<ManifoldPoint, kMaxHullVertices> near;
    std::size_t count = 0;
    for (int i = 0; i < corners; ++i) {
        const float gap = height + local_up.dot(points[i]);
        if (gap <= margin) {
            near[count++] = {
                b.to_world(points[i]) - 0.5F * gap * up, gap, static_cast<std::uint32_t>(i)};
        }
    }
    keep_four({near.data(), count}, out);
}

}  // namespace zoned::physics
