// Spheres and capsules against convex hulls.
#include "server/physics/narrowphase/collide.h"
#include "server/physics/narrowphase/gjk.h"
#include "server/physics/narrowphase/hull_clip.h"
#include "server/physics/shapes/convex/hull.h"

#include <algorithm>
#include <cmath>

namespace zoned::physics {

namespace {

/// Cores closer than this have no direction between them that means something, m.
constexpr double kCoresTouch = 1.0e-6;

/// The face that the point lies highest above (or least deep below).
int highest_face(const HullView& hull, const Vec3& p, float& height) {
    int best = 0;
    height = -INFINITY;
    for (int f = 0; f < hull.face_count; ++f) {
        const float h = hull.faces[f].normal.dot(p) - hull.faces[f].offset;
        if (h > height) {
            height = h;
            best = f;
        }
    }
    return best;
}

/// Whether the foot of the perpendicular from p lies on the face.
bool over_face(const HullView& hull, const HullFace& face, const Vec3& p) {
    Vec3 at = hull.corner(face, face.corners - 1);
    for (int i = 0; i < face.corners; ++i) {
        const Vec3 next = hull.corner(face, i);
        if ((next - at).cross(face.normal).dot(p - at) > 0.0F) {
            return false;
        }
        at = next;
    }
    return true;
}

/// A segment as two corners, padded.
struct SegmentColumns {
    std::array<float, kGroup> x, y, z;

    SegmentColumns(const Vec3& a, const Vec3& b) {
        for (std::size_t i = 0; i < kGroup; ++i) {
            const Vec3& p = i == 0 ? a : b;
            x[i] = p.x();
            y[i] = p.y();
            z[i] = p.z();
        }
    }

    [[nodiscard]] PointsView view() const { return {x.data(), y.data(), z.data(), kGroup}; }
};

/// How the core of a capsule, from c - e to c + e, lies to the hull; all in the hull's frame.
struct CoreContact {
    Vec3 normal = Vec3::UnitY();  // from the hull to the core
    float gap = 0.0F;             // between the hull and the core
    Vec3 on_core = Vec3::Zero();
    int face = 0;  // looks most along the normal
};

/// Of the part of the core that lies in the hull, the end that is lowest along the normal.
Vec3 lowest_inside(const HullView& hull, const Vec3& c, const Vec3& e, const Vec3& normal) {
    float lower = -1.0F;
    float upper = 1.0F;
    for (int f = 0; f < hull.face_count; ++f) {
        const HullFace& face = hull.faces[f];
        const float above = face.normal.dot(c) - face.offset;
        const float rate = face.normal.dot(e);
        if (rate > 0.0F) {
            upper = std::min(upper, -above / rate);
        } else if (rate < 0.0F) {
            lower = std::max(lower, -above / rate);
        }
    }
    const float end = normal.dot(e) > 0.0F ? std::max(lower, -1.0F) : std::min(upper, 1.0F);
    return c + std::clamp(end, -1.0F, 1.0F) * e;
}

/// The axis of least overlap between the hull and a core that cuts it: faces, and edges across the
/// core.
CoreContact least_overlap(const HullView& hull, const Vec3& c, const Vec3& e) {
    CoreContact best;
    best.gap = -INFINITY;
    for (int f = 0; f < hull.face_count; ++f) {
        const HullFace& face = hull.faces[f];
        const float gap = face.normal.dot(c) - std::abs(face.normal.dot(e)) - face.offset;
        if (gap > best.gap) {
            best.gap = gap;
            best.normal = face.normal;
        }
    }
    best.on_core = lowest_inside(hull, c, e, best.normal);
    for (int i = 0; i < hull.edge_count; ++i) {
        const HullEdge& edge = hull.edges[i];
        const Vec3& left = hull.faces[edge.left].normal;
        const Vec3& right = hull.faces[edge.right].normal;
        // Only where the core's great circle crosses the edge's arc is their product an axis.
        if (left.dot(e) * right.dot(e) >= 0.0F) {
            continue;
        }
        const Vec3 from = hull.points[edge.from];
        const Vec3 along = hull.points[edge.to] - from;
        Vec3 axis = along.cross(e);
        const float length2 = axis.squaredNorm();
        if (length2 < kParallel * kParallel * along.squaredNorm() * e.squaredNorm()) {
            continue;
        }
        axis *= (axis.dot(left + right) >= 0.0F ? 1.0F : -1.0F) / std::sqrt(length2);
        const float gap = axis.dot(c - from);
        if (gap > best.gap + 1.0e-3F * std::sqrt(e.squaredNorm())) {
            best.gap = gap;
            best.normal = axis;
            best.on_core = nearest_on_edges(from, along, c - e, 2.0F * e).on_b;
        }
    }
    return best;
}

CoreContact core_contact(const HullView& hull, const Vec3& c, const Vec3& e) {
    const SegmentColumns core(c - e, c + e);
    const Closest closest = closest_points(hull.points, core.view(), c);
    CoreContact out;
    if (closest.overlap || closest.distance <= kCoresTouch) {
        out = least_overlap(hull, c, e);
    } else {
        out.normal = closest.normal.cast<float>();
        out.gap = static_cast<float>(closest.distance);
        out.on_core = closest.on_b.cast<float>();
    }
    float most = -INFINITY;
    for (int f = 0; f < hull.face_count; ++f) {
        const float d = hull.faces[f].normal.dot(out.normal);
        if (d > most) {
            most = d;
            out.face = f;
        }
    }
    return out;
}

/// A capsule that lies along a face touches it with both ends: clips the core by the face's sides
/// and adds the near ends. False when the core does not run along that face.
bool add_along_face(const HullView& hull,
                    const HullFace& face,
                    const Vec3& c,
                    const Vec3& e,
                    float radius,
                    float margin,
                    Manifold& out) {
    float lower = -1.0F;
    float upper = 1.0F;
    Vec3 at = hull.corner(face, face.corners - 1);
    for (int i = 0; i < face.corners; ++i) {
        const Vec3 next = hull.corner(face, i);
        const Vec3 side = (next - at).cross(face.normal);
        const float above = side.dot(c - at);
        const float rate = side.dot(e);
        at = next;
        if (rate > 0.0F) {
            upper = std::min(upper, -above / rate);
        } else if (rate < 0.0F) {
            lower = std::max(lower, -above / rate);
        } else if (above > 0.0F) {
            return false;
        }
    }
    if (!(upper > lower)) {
        return false;
    }
    std::uint32_t feature = 0;
    for (const float t : {lower, upper}) {
        const Vec3 p = c + t * e;
        const float gap = face.normal.dot(p) - face.offset - radius;
        if (gap <= margin) {
            out.add(p - (radius + 0.5F * gap) * face.normal, gap, feature);
        }
        ++feature;
    }
    return true;
}

}  // namespace

void collide_sphere_hull(const Placed& a, const Placed& b, float margin, Manifold& out) {
    const HullView hull = hull_of(b.shape).view();
    const Vec3 c = b.to_local(a.position);
    const float r = a.shape.radius;
    float height = 0.0F;
    const HullFace& face = hull.faces[highest_face(hull, c, height)];
    Vec3 outward = face.normal;
    float gap = height;
    if (height > 0.0F && height <= r + margin && !over_face(hull, face, c)) {
        const SegmentColumns centre(c, c);
        const Closest closest = closest_points(hull.points, centre.view(), c);
        if (!closest.overlap && closest.distance > kCoresTouch) {
            outward = closest.normal.cast<float>();
            gap = static_cast<float>(closest.distance);
        }
    }
    out.normal = -outward;
    out.separation = gap - r;
    if (out.separation <= margin) {
        out.add(c - (r + 0.5F * out.separation) * outward, out.separation, 0);
    }
    to_world(b, out);
}

void collide_capsule_hull(const Placed& a, const Placed& b, float margin, Manifold& out) {
    const HullView hull = hull_of(b.shape).view();
    const Vec3 c = b.to_local(a.position);
    const Vec3 e = b.rotation.transpose() * a.rotation.col(1) * a.shape.half_segment;
    const float r = a.shape.radius;
    const CoreContact core = core_contact(hull, c, e);
    const HullFace& face = hull.faces[core.face];
    out.separation = core.gap - r;
    // Along a face: the normal is the face's and the core is within about 8 degrees of it.
    if (face.normal.dot(core.normal) > 0.99F &&
        std::abs(face.normal.dot(e)) < 0.14F * a.shape.half_segment &&
        add_along_face(hull, face, c, e, r, margin, out)) {
        out.normal = -face.normal;
    } else {
        out.normal = -core.normal;
        if (out.separation <= margin) {
            out.add(core.on_core - (r + 0.5F * out.separation) * core.normal, out.separation, 2);
        }
    }
    to_world(b, out);
}

}  // namespace zoned::physics
