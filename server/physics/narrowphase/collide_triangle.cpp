#include "server/physics/narrowphase/collide_triangle.h"

#include "server/physics/narrowphase/gjk.h"
#include "server/physics/narrowphase/hull_clip.h"
#include "server/physics/narrowphase/surface_face.h"
#include "server/physics/shapes/convex/hull.h"

#include <algorithm>
#include <cmath>

namespace zoned::physics {

namespace {

/// Nearer than this there is no direction from the triangle to a point, m.
constexpr float kOnTriangle = 1.0e-6F;
/// A normal within this angle of the face's, in radians, is the face's.
constexpr float kFlat = 2.0e-3F;
/// Edges that pass each other at this distance or less cross, m.
constexpr float kCrossing = 1.0e-3F;

std::size_t index(int i) {
    return static_cast<std::size_t>(i);
}

/// The part of the core c - e .. c + e that lies over the triangle, as parameters; false when none.
bool clip_core(const Triangle& t, const Vec3& c, const Vec3& e, float& lower, float& upper) {
    lower = -1.0F;
    upper = 1.0F;
    for (std::size_t i = 0; i < 3; ++i) {
        const Vec3 side = t.outward(i);
        const float beyond = side.dot(c - t.corner[i]);
        const float rate = side.dot(e);
        if (rate > 0.0F) {
            upper = std::min(upper, -beyond / rate);
        } else if (rate < 0.0F) {
            lower = std::max(lower, -beyond / rate);
        } else if (beyond > 0.0F) {
            return false;
        }
    }
    return lower <= upper;
}

/// Closest points of a core and a triangle that do not intersect.
struct CoreDistance {
    float distance = INFINITY;
    TrianglePoint on_triangle;
    Vec3 on_core = Vec3::Zero();
};

CoreDistance core_distance(const Triangle& t, const Vec3& c, const Vec3& e) {
    CoreDistance best;
    for (const float end : {-1.0F, 1.0F}) {
        const Vec3 p = c + end * e;
        const TrianglePoint q = nearest_on_triangle(t.corner, p);
        const float d = (p - q.point).norm();
        if (d < best.distance) {
            best = {d, q, p};
        }
    }
    for (int i = 0; i < 3; ++i) {
        const Vec3 edge = t.edge(index(i));
        const SegmentPoints p = nearest_on_edges(t.corner[index(i)], edge, c - e, 2.0F * e);
        const float d = (p.on_b - p.on_a).norm();
        // An end or a corner that is as near says more about the feature.
        if (d < best.distance - kOnTriangle) {
            const float along = edge.dot(p.on_a - t.corner[index(i)]) / edge.squaredNorm();
            best = {d, {p.on_a, i, -1}, p.on_b};
            if (along <= 0.0F || along >= 1.0F) {
                best.on_triangle = {p.on_a, -1, along <= 0.0F ? i : (i + 1) % 3};
            }
        }
    }
    return best;
}

bool cuts(const Triangle& t, const Vec3& c, const Vec3& e) {
    const float h0 = t.height(c - e);
    const float h1 = t.height(c + e);
    if (h0 * h1 > 0.0F || h0 == h1) {
        return false;
    }
    const Vec3 p = c + e * ((h0 + h1) / (h0 - h1));
    for (std::size_t i = 0; i < 3; ++i) {
        if (t.outward(i).dot(p - t.corner[i]) > 0.0F) {
            return false;
        }
    }
    return true;
}

/// Whether the edges of an axis cross, seen along it. A triangle is no closed surface: its edge may
/// be the best that it has to offer though the hull touches another triangle, far from that edge.
bool edges_cross(const HullView& a, const HullView& b, const HullAxis& axis) {
    const HullEdge& ea = a.edges[axis.i];
    const HullEdge& eb = b.edges[axis.j];
    const Vec3 pa = a.points[ea.from];
    const Vec3 pb = b.points[eb.from];
    const SegmentPoints p = nearest_on_edges(pa, a.points[ea.to] - pa, pb, b.points[eb.to] - pb);
    const Vec3 apart = p.on_b - p.on_a;
    const Vec3 beside = apart - axis.normal.dot(apart) * axis.normal;
    return beside.squaredNorm() <= kCrossing * kCrossing;
}

}  // namespace

bool allows(const Triangle& t, const TrianglePoint& feature, const Vec3& unit) {
    if (feature.edge >= 0) {
        return t.allows(index(feature.edge), unit);
    }
    if (feature.corner >= 0) {
        return t.allows(index(feature.corner), unit) &&
               t.allows(index((feature.corner + 2) % 3), unit);
    }
    return unit.dot(t.normal) > 0.0F;
}

SurfaceVisitor::SurfaceVisitor(const Placed& shape) : shape_(shape) {
    switch (shape.shape.kind) {
        case ShapeKind::kCapsule:
            half_axis_ = shape.rotation.col(1) * shape.shape.half_segment;
            break;
        case ShapeKind::kBox:
            box_.emplace(shape.shape.half_extents);
            hull_.emplace(box_->view(), shape.rotation, shape.position);
            scale_ = bias_scale(shape.shape.half_extents.norm());
            break;
        case ShapeKind::kHull:
            hull_.emplace(hull_of(shape.shape).view(), shape.rotation, shape.position);
            scale_ = bias_scale(hull_of(shape.shape).radius());
            break;
        default:
            break;
    }
}

void SurfaceVisitor::collide(const Triangle& t, float margin, Manifold& out) const {
    out.count = 0;
    out.normal = t.normal;
    out.separation = INFINITY;
    if (t.height(shape_.position) < 0.0F) {
        return;
    }
    if (hull_) {
        collide_hull(t, margin, out);
    } else if (shape_.shape.kind == ShapeKind::kCapsule) {
        collide_capsule(t, margin, out);
    } else {
        collide_sphere(t, margin, out);
    }
}

void SurfaceVisitor::collide_sphere(const Triangle& t, float margin, Manifold& out) const {
    const float r = shape_.shape.radius;
    const Vec3& c = shape_.position;
    const TrianglePoint nearest = nearest_on_triangle(t.corner, c);
    const Vec3 d = c - nearest.point;
    const float distance = d.norm();
    out.separation = distance - r;
    if (out.separation > margin) {
        return;
    }
    if (distance > kOnTriangle) {
        const Vec3 unit = d / distance;
        if (!allows(t, nearest, unit)) {
            return;
        }
        out.normal = unit.dot(t.normal) > 1.0F - 0.5F * kFlat * kFlat ? t.normal : unit;
    }
    out.add(c - (r + 0.5F * out.separation) * out.normal, out.separation, 0);
}

/// A core that runs along the triangle touches it with both ends of the part over it; otherwise the
/// nearest points count, where the surface has their direction as a normal.
void SurfaceVisitor::collide_capsule(const Triangle& t, float margin, Manifold& out) const {
    const float r = shape_.shape.radius;
    const Vec3& c = shape_.position;
    const Vec3& e = half_axis_;
    const float lowest_end = t.height(c) - std::abs(t.normal.dot(e));
    if (lowest_end - r > margin) {
        out.separation = lowest_end - r;
        return;
    }
    float lower = 0.0F;
    float upper = 0.0F;
    const bool over = clip_core(t, c, e, lower, upper);
    if (!cuts(t, c, e)) {
        const CoreDistance core = core_distance(t, c, e);
        out.separation = core.distance - r;
        if (out.separation > margin) {
            return;
        }
        const TrianglePoint& at = core.on_triangle;
        const bool on_face = at.edge < 0 && at.corner < 0;
        const Vec3 unit = (core.on_core - at.point) / std::max(core.distance, kOnTriangle);
        // Within about 8 degrees the core runs along the face and touches with both ends.
        const bool along = over && unit.dot(t.normal) > 0.99F;
        if (!on_face && !along && core.distance > kOnTriangle && allows(t, at, unit)) {
            out.normal = unit;
            out.add(core.on_core - (r + 0.5F * out.separation) * unit,
                    out.separation,
                    static_cast<std::uint32_t>(2 + (at.edge >= 0 ? at.edge : 3 + at.corner)));
            return;
        }
    }
    if (!over) {
        return;
    }
    std::uint32_t feature = 0;
    for (const float s : {lower, upper}) {
        const Vec3 p = c + s * e;
        const float gap = t.height(p) - r;
        out.separation = std::min(out.separation, gap);
        if (gap <= margin) {
            out.add(p - (r + 0.5F * gap) * t.normal, gap, feature);
        }
        ++feature;
    }
}

void SurfaceVisitor::collide_hull(const Triangle& t, float margin, Manifold& out) const {
    const SurfaceFace triangle(t);
    const HullView hull = hull_->view();
    const HullAxes axes = triangle.find_axes(hull, margin, scale_);
    const HullAxis& axis = axes.best(scale_);
    out.normal = axis.normal;
    out.separation = axis.separation;
    if (axis.separation > margin) {
        return;
    }
    if (axis.kind != AxisKind::kEdges || edges_cross(triangle.view(), hull, axis)) {
        add_points(triangle.view(), hull, axis, margin, out);
    }
    if (out.count == 0 && axis.kind != AxisKind::kFaceA) {
        // The contact lies beside the feature that won; the part of the hull over the triangle
        // still has to stay above it.
        out.normal = t.normal;
        add_points(triangle.view(),
                   hull,
                   {axis.separation, AxisKind::kFaceA, 0, 0, t.normal},
                   margin,
                   out);
    }
}

void SurfaceVisitor::collide_half_space(const Triangle& t, float margin, Manifold& out) const {
    // A plane whose body frame has its y axis along the normal.
    const Shape plane = Shape::plane();
    Mat3 rotation;
    rotation.col(1) = t.normal;
    rotation.col(0) = t.normal.unitOrthogonal();
    rotation.col(2) = rotation.col(0).cross(t.normal);
    const Placed place{plane, t.corner[0], rotation};
    out.count = 0;
    switch (shape_.shape.kind) {
        case ShapeKind::kSphere:
            collide_sphere_plane(shape_, place, margin, out);
            break;
        case ShapeKind::kCapsule:
            collide_capsule_plane(shape_, place, margin, out);
            break;
        case ShapeKind::kBox:
            collide_box_plane(shape_, place, margin, out);
            break;
        default:
            collide_plane_hull(place, shape_, margin, out);
            return;
    }
    out.flip();
}

float SurfaceVisitor::distance(const Triangle& t, Vec3& normal) const {
    const SurfaceFace triangle(t);
    if (hull_) {
        const Closest c = closest_points(
            triangle.view().points, hull_->view().points, shape_.position - t.corner[0]);
        normal = c.normal.cast<float>();
        return static_cast<float>(c.distance);
    }
    const bool cut =
        shape_.shape.kind == ShapeKind::kCapsule && cuts(t, shape_.position, half_axis_);
    const CoreDistance core = core_distance(t, shape_.position, half_axis_);
    if (cut || core.distance <= kOnTriangle) {
        return 0.0F;
    }
    normal = (core.on_core - core.on_triangle.point) / core.distance;
    return std::max(core.distance - shape_.shape.radius, 0.0F);
}

}  // namespace zoned::physics
