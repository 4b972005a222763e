#include "tests/scenario/ray.h"

#include "tests/scenario/penetration.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

namespace zoned::scenario {

namespace {

constexpr double kMiss = std::numeric_limits<double>::infinity();

/// A ray in the axes of a solid.
struct Local {
    Vec3d origin;
    Vec3d direction;
};

/// Smaller root of |o + t d|^2 = r^2 where it is not behind the origin; `dd` = |d|^2 and so on.
double first_root(double dd, double od, double oo, double r) {
    const double c = oo - r * r;
    const double discriminant = od * od - dd * c;
    if (dd == 0.0 || discriminant < 0.0) {
        return kMiss;
    }
    const double t = (-od - std::sqrt(discriminant)) / dd;
    return t >= 0.0 ? t : kMiss;
}

double to_sphere(const Local& ray, const Vec3d& centre, double radius) {
    const Vec3d o = ray.origin - centre;
    return first_root(1.0, o.dot(ray.direction), o.squaredNorm(), radius);
}

/// Slabs (Kay, Kajiya, "Ray tracing complex scenes", SIGGRAPH 1986).
double to_box(const Local& ray, const Vec3d& h) {
    double enter = 0.0;
    double leave = kMiss;
    for (int i = 0; i < 3; ++i) {
        if (ray.direction[i] == 0.0) {
            if (std::abs(ray.origin[i]) > h[i]) {
                return kMiss;
            }
            continue;
        }
        const double a = (-h[i] - ray.origin[i]) / ray.direction[i];
        const double b = (h[i] - ray.origin[i]) / ray.direction[i];
        enter = std::max(enter, std::min(a, b));
        leave = std::min(leave, std::max(a, b));
    }
    return enter <= leave ? enter : kMiss;
}

/// A capsule is a cylinder between two balls: the first of the three surfaces that is met counts.
double to_capsule(const Local& ray, double radius, double half) {
    const Vec3d nearest(0.0, std::clamp(ray.origin.y(), -half, half), 0.0);
    if ((ray.origin - nearest).norm() <= radius) {
        return 0.0;
    }
    double t = std::min(to_sphere(ray, {0.0, half, 0.0}, radius),
                        to_sphere(ray, {0.0, -half, 0.0}, radius));
    const Eigen::Vector2d o(ray.origin.x(), ray.origin.z());
    const Eigen::Vector2d d(ray.direction.x(), ray.direction.z());
    const double side = first_root(d.squaredNorm(), o.dot(d), o.squaredNorm(), radius);
    if (std::isfinite(side) && std::abs(ray.origin.y() + side * ray.direction.y()) <= half) {
        t = std::min(t, side);
    }
    return t;
}

}  // namespace

double ray_distance(const Ray& ray, const Solid& solid, const Pose& pose) {
    const Quatd back = pose.orientation.conjugate();
    const Local local{back * (ray.origin - pose.position), back * ray.direction};
    double t = kMiss;
    switch (solid.form) {
        case Form::kSphere:
            t = local.origin.norm() <= solid.radius ? 0.0
                                                    : to_sphere(local, Vec3d::Zero(), solid.radius);
            break;
        case Form::kBox:
            t = to_box(local, solid.half_extents);
            break;
        case Form::kCapsule:
            t = to_capsule(local, solid.radius, solid.half_segment);
            break;
        default:
            throw std::logic_error("no ray meets this form of solid");
    }
    return t <= ray.length ? t : kMiss;
}

double ray_distance(const Ray& ray, std::span<const Body> bodies) {
    double least = kMiss;
    for (const Body& body : bodies) {
        // The ray can't hit a body whose bounding sphere it misses.
        const Vec3d to = body.pose.position - ray.origin;
        const double reach = bounding_radius(body.solid) + 1e-6;
        if (to.cross(ray.direction).squaredNorm() > reach * reach) {
            continue;
        }
        least = std::min(least, ray_distance(ray, body.solid, body.pose));
    }
    return least;
}

}  // namespace zoned::scenario
