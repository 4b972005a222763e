#include "tests/scenario/penetration.h"

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

}  // namespace

double penetration(const Solid& a, const Pose& at_a, const Solid& b, const Pose& at_b) {
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
    }
    return 0.0;
}

}  // namespace zoned::scenario
