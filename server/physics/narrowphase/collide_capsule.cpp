#include "server/physics/narrowphase/collide.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

namespace zoned::physics {

namespace {

/// Parameters of the nearest points of two segments pa + s da, |s| <= ha and pb + t db, |t| <= hb
/// with unit directions (Ericson, Real-Time Collision Detection, section 5.1.9).
std::array<float, 2> nearest_on_segments(const Vec3& da,
                                         float ha,
                                         const Vec3& db,
                                         float hb,
                                         const Vec3& from_b_to_a) {
    const float b = da.dot(db);
    const float c = da.dot(from_b_to_a);
    const float f = db.dot(from_b_to_a);
    const float denominator = 1.0F - b * b;
    float s = denominator > 1.0e-6F ? std::clamp((b * f - c) / denominator, -ha, ha) : 0.0F;
    float t = b * s + f;
    if (std::abs(t) > hb) {
        t = std::clamp(t, -hb, hb);
        s = std::clamp(b * t - c, -ha, ha);
    }
    return {s, t};
}

/// Parameter of the point of a segment (centre c, half vector e, parameter in [-1, 1]) that is
/// nearest to an origin-centred box. The squared distance is convex and piecewise quadratic in the
/// parameter with breaks where a coordinate enters or leaves its slab; its derivative is increasing
/// and piecewise linear, so its root lies between two neighbouring breaks.
float nearest_to_box(const Vec3& c, const Vec3& e, const Vec3& half) {
    std::array<float, 8> breaks{};
    std::size_t count = 0;
    breaks[count++] = -1.0F;
    breaks[count++] = 1.0F;
    for (int i = 0; i < 3; ++i) {
        for (const float side : {-half[i], half[i]}) {
            const float t = (side - c[i]) / e[i];
            if (t > -1.0F && t < 1.0F) {
                breaks[count++] = t;
            }
        }
    }
    for (std::size_t i = 1; i < count; ++i) {
        for (std::size_t k = i; k > 0 && breaks[k] < breaks[k - 1]; --k) {
            std::swap(breaks[k], breaks[k - 1]);
        }
    }
    const auto slope = [&](float t) {
        const Vec3 p = c + t * e;
        return e.dot(p - p.cwiseMax(-half).cwiseMin(half));
    };
    // Where the segment runs along a face or inside the box the slope is zero over a stretch: its
    // beginning is taken, and the callers add both ends of such a contact.
    float before = slope(breaks[0]);
    if (before > 0.0F) {
        return breaks[0];
    }
    for (std::size_t i = 1; i < count; ++i) {
        const float after = slope(breaks[i]);
        if (after > 0.0F) {
            const float t0 = breaks[i - 1];
            return before == after ? t0 : t0 + (breaks[i] - t0) * (-before / (after - before));
        }
        before = after;
    }
    return 1.0F;
}

/// The axis of least overlap between a segment and a box that its core cuts (three faces, three
/// edge cross products), local to the box, from the box to the segment; `separation` excludes the
/// radius.
Vec3 least_overlap_axis(const Vec3& c, const Vec3& e, const Vec3& half, float& separation) {
    Vec3 best = Vec3::UnitY();
    separation = -INFINITY;
    const auto consider = [&](const Vec3& axis, float bias) {
        const float distance = axis.dot(c);
        const float reach = half.dot(axis.cwiseAbs()) + std::abs(axis.dot(e));
        const float gap = std::abs(distance) - reach;
        if (gap > separation + bias) {
            separation = gap;
            best = distance >= 0.0F ? axis : Vec3(-axis);
        }
    };
    for (int i = 0; i < 3; ++i) {
        consider(Vec3::Unit(i), 0.0F);
    }
    for (int i = 0; i < 3; ++i) {
        const Vec3 axis = Vec3::Unit(i).cross(e);
        const float length = axis.norm();
        if (length > 1.0e-3F * e.norm()) {
            consider(axis / length, 1.0e-3F);
        }
    }
    return best;
}

/// A capsule that lies along a face touches it with both ends: clips the core segment by the face's
/// sides and adds the near ends. False when the segment does not run along that face.
bool add_face_contact(const Placed& box,
                      const Vec3& c,
                      const Vec3& e,
                      float radius,
                      int axis,
                      float margin,
                      Manifold& out) {
    const Vec3& half = box.shape.half_extents;
    const float side = c[axis] >= 0.0F ? 1.0F : -1.0F;
    float lower = -1.0F;
    float upper = 1.0F;
    for (int i = 0; i < 3; ++i) {
        if (i == axis || std::abs(e[i]) < 1.0e-9F) {
            continue;
        }
        const float t0 = (-half[i] - c[i]) / e[i];
        const float t1 = (half[i] - c[i]) / e[i];
        lower = std::max(lower, std::min(t0, t1));
        upper = std::min(upper, std::max(t0, t1));
    }
    if (upper <= lower) {
        return false;
    }
    out.normal = side * box.rotation.col(axis);
    std::uint32_t feature = 0;
    for (const float t : {lower, upper}) {
        const Vec3 p = c + t * e;
        const float gap = side * p[axis] - half[axis] - radius;
        if (gap <= margin) {
            Vec3 middle = p;
            middle[axis] = side * (half[axis] + 0.5F * gap);
            out.add(box.to_world(middle), gap, feature);
        }
        ++feature;
    }
    return true;
}

}  // namespace

void collide_capsule_capsule(const Placed& a, const Placed& b, float margin, Manifold& out) {
    const Vec3 da = a.rotation.col(1);
    const Vec3 db = b.rotation.col(1);
    const float ha = a.shape.half_segment;
    const float hb = b.shape.half_segment;
    const float ra = a.shape.radius;
    const float rb = b.shape.radius;
    const float along = da.dot(db);
    if (std::abs(along) > 0.9995F) {
        // Nearly parallel: the overlap of b's core with a's, seen along a, has two ends.
        const float centre = da.dot(b.position - a.position);
        const float lower = std::max(-ha, centre - hb);
        const float upper = std::min(ha, centre + hb);
        if (upper - lower > 0.01F * (ha + hb)) {
            std::uint32_t feature = 1;
            Manifold ends[2];
            for (const float s : {lower, upper}) {
                const Vec3 pa = a.position + s * da;
                const float t = std::clamp(db.dot(pa - b.position), -hb, hb);
                collide_balls(pa, ra, b.position + t * db, rb, feature, margin, ends[feature - 1]);
                ++feature;
            }
            const Manifold& nearer = ends[1].separation < ends[0].separation ? ends[1] : ends[0];
            out.normal = nearer.normal;
            out.separation = nearer.separation;
            for (const Manifold& end : ends) {
                if (end.count > 0) {
                    out.add(end.points[0].point, end.points[0].separation, end.points[0].feature);
                }
            }
            return;
        }
    }
    const auto [s, t] = nearest_on_segments(da, ha, db, hb, a.position - b.position);
    collide_balls(a.position + s * da, ra, b.position + t * db, rb, 0, margin, out);
}

void collide_box_capsule(const Placed& a, const Placed& b, float margin, Manifold& out) {
    const Vec3& half = a.shape.half_extents;
    const float r = b.shape.radius;
    const Vec3 c = a.to_local(b.position);
    const Vec3 e = a.rotation.transpose() * b.rotation.col(1) * b.shape.half_segment;
    const float t = nearest_to_box(c, e, half);
    const Vec3 p = c + t * e;
    const Vec3 on_box = p.cwiseMax(-half).cwiseMin(half);
    const float distance = (p - on_box).norm();
    Vec3 normal = Vec3::Zero();
    float core_gap = distance;
    if (distance > 1.0e-5F) {
        normal = (p - on_box) / distance;
    } else {
        normal = least_overlap_axis(c, e, half, core_gap);
    }
    out.separation = core_gap - r;
    int axis = 0;
    const float steep = normal.cwiseAbs().maxCoeff(&axis);
    // Along a face: the normal is the face's and the core is within about 8 degrees of it.
    if (steep > 0.99F && std::abs(e[axis]) < 0.14F * b.shape.half_segment &&
        add_face_contact(a, c, e, r, axis, margin, out)) {
        return;
    }
    out.normal = a.rotation * normal;
    if (out.separation <= margin) {
        // The end of the core that reaches deepest stands for it when the core cuts the box.
        const float end = distance > 1.0e-5F ? t : (e.dot(normal) > 0.0F ? -1.0F : 1.0F);
        const Vec3 on_capsule = c + end * e - r * normal;
        out.add(a.to_world(on_capsule - 0.5F * out.separation * normal), out.separation, 2);
    }
}

}  // namespace zoned::physics
