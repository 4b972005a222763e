#include "tests/scenario/penetration.h"

#include "tests/scenario/polyhedron_overlap.h"
#include "tests/scenario/solid_geometry.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace zoned::scenario {

namespace {

using Mat3d = Eigen::Matrix3d;

/// The core of a sphere or capsule: the points centre + t half, t in [-1, 1].
struct Core {
    Vec3d centre;
    Vec3d half;
};

Core core_of(const Solid& solid, const Pose& pose) {
    if (solid.form == Form::kSphere) {
        return {pose.position, Vec3d::Zero()};
    }
    return {pose.position, pose.orientation * Vec3d(0.0, solid.half_segment, 0.0)};
}

/// Distance of two segments (Ericson, "Real-Time Collision Detection", section 5.1.9, in the
/// parameters -1..1).
double distance(const Core& a, const Core& b) {
    const Vec3d r = a.centre - b.centre;
    const double aa = a.half.squaredNorm();
    const double bb = b.half.squaredNorm();
    const double ab = a.half.dot(b.half);
    const double ar = a.half.dot(r);
    const double br = b.half.dot(r);
    const double determinant = aa * bb - ab * ab;
    double s = 0.0;
    if (determinant > 1e-14 * aa * bb) {
        s = std::clamp((ab * br - ar * bb) / determinant, -1.0, 1.0);
    }
    double t = bb > 0.0 ? std::clamp((ab * s + br) / bb, -1.0, 1.0) : 0.0;
    s = aa > 0.0 ? std::clamp((ab * t - ar) / aa, -1.0, 1.0) : 0.0;
    t = bb > 0.0 ? std::clamp((ab * s + br) / bb, -1.0, 1.0) : 0.0;
    return (r + s * a.half - t * b.half).norm();
}

/// Least overlap of a box [-h, h] and a segment over the axes on which they can be apart; negative
/// where an axis parts them.
double overlap_of_axes(const Vec3d& h, const Core& segment) {
    double least = std::numeric_limits<double>::max();
    const auto look = [&](const Vec3d& axis) {
        const double length = axis.norm();
        if (length < 1e-9 * (1.0 + segment.half.norm())) {
            return;
        }
        const Vec3d n = axis / length;
        const double reach = n.cwiseAbs().dot(h) + std::abs(n.dot(segment.half));
        least = std::min(least, reach - std::abs(n.dot(segment.centre)));
    };
    for (int i = 0; i < 3; ++i) {
        look(Vec3d::Unit(i));
        look(Vec3d::Unit(i).cross(segment.half));
    }
    return least;
}

/// Distance of a segment to the box [-h, h]; negative inside: the shortest translation out.
double distance_to_box(const Vec3d& h, const Core& segment) {
    // The squared distance is convex along the segment: its derivative grows, so that bisection
    // finds where it is zero.
    const auto gap = [&](double t) {
        const Vec3d p = segment.centre + t * segment.half;
        return Vec3d(p - p.cwiseMax(-h).cwiseMin(h));
    };
    double lower = -1.0;
    double upper = 1.0;
    for (int i = 0; i < 60; ++i) {
        const double middle = 0.5 * (lower + upper);
        (gap(middle).dot(segment.half) > 0.0 ? upper : lower) = middle;
    }
    const double outside =
        std::min({gap(0.5 * (lower + upper)).norm(), gap(-1.0).norm(), gap(1.0).norm()});
    if (outside > 1e-12) {
        return outside;
    }
    return -std::max(overlap_of_axes(h, segment), 0.0);
}

double box_box(const Solid& a, const Pose& at_a, const Solid& b, const Pose& at_b) {
    const Mat3d ra = at_a.orientation.toRotationMatrix();
    const Mat3d rb = at_b.orientation.toRotationMatrix();
    const Vec3d between = at_b.position - at_a.position;
    double least = std::numeric_limits<double>::max();
    const auto look = [&](const Vec3d& axis) {
        const double length = axis.norm();
        if (length < 1e-9) {
            return;  // parallel edges: their cross product is no axis
        }
        const Vec3d n = axis / length;
        const double reach = (ra.transpose() * n).cwiseAbs().dot(a.half_extents) +
                             (rb.transpose() * n).cwiseAbs().dot(b.half_extents);
        least = std::min(least, reach - std::abs(n.dot(between)));
    };
    for (int i = 0; i < 3; ++i) {
        look(ra.col(i));
        look(rb.col(i));
        for (int j = 0; j < 3; ++j) {
            look(ra.col(i).cross(rb.col(j)));
        }
    }
    return std::max(least, 0.0);
}

double deepest_parts(const Solid& a, const Pose& at_a, const Solid& b, const Pose& at_b) {
    if (a.form != Form::kCompound) {
        return deepest_parts(b, at_b, a, at_a);
    }
    double most = 0.0;
    for (const SolidPart& part : a.geometry->parts) {
        const Pose at{at_a.position + at_a.orientation * part.pose.position,
                      at_a.orientation * part.pose.orientation};
        const double reach = bounding_radius(part.solid) + bounding_radius(b);
        if (b.form == Form::kMesh || (at.position - at_b.position).norm() < reach) {
            most = std::max(most, penetration(part.solid, at, b, at_b));
        }
    }
    return most;
}

/// A hull against a box, hull, ball or capsule.
double with_hull(const Solid& a, const Pose& at_a, const Solid& b, const Pose& at_b) {
    const auto flat = [](const Solid& s) {
        return s.form == Form::kHull || s.form == Form::kBox;
    };
    if (!flat(a)) {
        return with_hull(b, at_b, a, at_a);
    }
    const SolidGeometry first = polyhedron_of(a);
    const Quatd to_a = at_a.orientation.conjugate();
    const Vec3d shift = to_a * (at_b.position - at_a.position);
    if (flat(b)) {
        return polyhedra_overlap(first, polyhedron_of(b), {shift, to_a * at_b.orientation});
    }
    const Core other = core_of(b, at_b);
    return std::max(b.radius - least_distance(first, shift, to_a * other.half), 0.0);
}

}  // namespace

double penetration(const Solid& a, const Pose& at_a, const Solid& b, const Pose& at_b) {
    if (a.form == Form::kCompound || b.form == Form::kCompound) {
        return deepest_parts(a, at_a, b, at_b);
    }
    if (a.form == Form::kMesh || b.form == Form::kMesh) {
        return a.form == Form::kMesh ? depth_behind(*a.geometry, at_a, b, at_b)
                                     : depth_behind(*b.geometry, at_b, a, at_a);
    }
    if (a.form == Form::kHull || b.form == Form::kHull) {
        return with_hull(a, at_a, b, at_b);
    }
    if (a.form == Form::kBox && b.form == Form::kBox) {
        return box_box(a, at_a, b, at_b);
    }
    if (b.form == Form::kBox) {
        return penetration(b, at_b, a, at_a);
    }
    const Core other = core_of(b, at_b);
    if (a.form == Form::kBox) {
        const Quatd to_box = at_a.orientation.conjugate();
        const Core local{to_box * (other.centre - at_a.position), to_box * other.half};
        return std::max(b.radius - distance_to_box(a.half_extents, local), 0.0);
    }
    return std::max(a.radius + b.radius - distance(core_of(a, at_a), other), 0.0);
}

double depth_below_ground(const Solid& solid, const Pose& pose) {
    if (solid.form == Form::kHull) {
        double lowest = INFINITY;
        for (const Vec3d& p : solid.geometry->points) {
            lowest = std::min(lowest, (pose.orientation * p).y());
        }
        return std::max(-lowest - pose.position.y(), 0.0);
    }
    if (solid.form == Form::kCompound) {
        double depth = 0.0;
        for (const SolidPart& part : solid.geometry->parts) {
            const Pose at{pose.position + pose.orientation * part.pose.position,
                          pose.orientation * part.pose.orientation};
            depth = std::max(depth, depth_below_ground(part.solid, at));
        }
        return depth;
    }
    double reach = 0.0;
    if (solid.form == Form::kBox) {
        const Vec3d up = pose.orientation.conjugate() * Vec3d::UnitY();
        reach = up.cwiseAbs().dot(solid.half_extents);
    } else {
        reach = solid.radius + std::abs(core_of(solid, pose).half.y());
    }
    return std::max(reach - pose.position.y(), 0.0);
}

double bounding_radius(const Solid& solid) {
    switch (solid.form) {
        case Form::kSphere:
            return solid.radius;
        case Form::kBox:
            return solid.half_extents.norm();
        case Form::kCapsule:
            return solid.radius + solid.half_segment;
        case Form::kHull:
        case Form::kCompound:
        case Form::kMesh:
            return solid.geometry->radius;
    }
    return 0.0;
}

}  // namespace zoned::scenario
