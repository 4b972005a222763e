#include "tests/scenario/physics_scenes.h"

#include "tests/scenario/scene_parts.h"
#include "tests/scenario/solid_geometry.h"
#include "shared/core/rng.h"

#include <array>
#include <cmath>
#include <numbers>

namespace zoned::scenario {

Solid Solid::sphere(double radius) {
    Solid s;
    s.form = Form::kSphere;
    s.radius = radius;
    return s;
}

Solid Solid::box(const Vec3d& size) {
    Solid s;
    s.form = Form::kBox;
    s.half_extents = 0.5 * size;
    return s;
}

Solid Solid::capsule(double radius, double half_segment) {
    Solid s;
    s.form = Form::kCapsule;
    s.radius = radius;
    s.half_segment = half_segment;
    return s;
}

double Solid::volume() const {
    constexpr double kPi = std::numbers::pi;
    switch (form) {
        case Form::kSphere:
            return 4.0 / 3.0 * kPi * radius * radius * radius;
        case Form::kBox:
            return 8.0 * half_extents.prod();
        case Form::kCapsule:
            return kPi * radius * radius * (4.0 / 3.0 * radius + 2.0 * half_segment);
        case Form::kHull:
        case Form::kCompound:
        case Form::kMesh:
            return geometry->volume;
    }
    return 0.0;
}

Vec3d Solid::inertia_per_mass() const {
    switch (form) {
        case Form::kSphere:
            return Vec3d::Constant(0.4 * radius * radius);
        case Form::kBox: {
            const Vec3d q = half_extents.cwiseProduct(half_extents) / 3.0;
            return {q.y() + q.z(), q.x() + q.z(), q.x() + q.y()};
        }
        case Form::kCapsule: {
            // A cylinder and two half balls, weighted by volume. A half ball's centre is 3/8 r from
            // its base. Its moment about a diameter of the base is that of the ball, 2/5 r2.
            const double r = radius;
            const double h = half_segment;
            const double balls = 4.0 / 3.0 * r / (4.0 / 3.0 * r + 2.0 * h);
            const double cylinder = 1.0 - balls;
            const double along = cylinder * 0.5 * r * r + balls * 0.4 * r * r;
            const double across = cylinder * (0.25 * r * r + h * h / 3.0) +
                                  balls * (0.4 * r * r + h * h + 0.75 * h * r);
            return {across, along, across};
        }
        case Form::kHull:
        case Form::kCompound:
        case Form::kMesh:
            return geometry->inertia_per_mass;
    }
    return Vec3d::Zero();
}

int Description::first_dynamic() const {
    int i = 0;
    while (i < static_cast<int>(bodies.size()) && bodies[static_cast<std::size_t>(i)].mass == 0.0) {
        ++i;
    }
    return i;
}

Body fixed_box(const Vec3d& size, const Vec3d& middle, double friction, double restitution) {
    Body body;
    body.solid = Solid::box(size);
    body.mass = 0.0;
    body.friction = friction;
    body.restitution = restitution;
    body.pose.position = middle;
    return body;
}

Body ground(double width, double friction, double restitution) {
    Body body = fixed_box({width, 2.0, width}, {0.0, -1.0, 0.0}, friction, restitution);
    body.ground = true;
    return body;
}

Body at(const Solid& solid, double mass, const Vec3d& position, double friction) {
    Body body;
    body.solid = solid;
    body.mass = mass;
    body.friction = friction;
    body.pose.position = position;
    return body;
}

Description pyramid() {
    constexpr int kRows = 20;
    constexpr double kFriction = 0.6;
    Description d;
    d.bodies.push_back(ground(100.0, kFriction));
    for (int row = 0; row < kRows; ++row) {
        for (int i = 0; i < kRows - row; ++i) {
            const double x = (i - 0.5 * (kRows - 1 - row)) * 1.1;
            d.bodies.push_back(at(Solid::box(Vec3d::Ones()), 1.0, {x, row + 0.5, 0.0}, kFriction));
        }
    }
    return d;
}

Description column(int count, double top_mass) {
    constexpr double kFriction = 0.6;
    Description d;
    d.bodies.push_back(ground(100.0, kFriction));
    for (int i = 0; i < count; ++i) {
        const double mass = i + 1 == count ? top_mass : 1.0;
        d.bodies.push_back(at(Solid::box(Vec3d::Ones()), mass, {0.0, i + 0.5, 0.0}, kFriction));
    }
    return d;
}

Description pile(int side) {
    constexpr double kFriction = 0.5;
    constexpr double kSpacing = 1.3;
    constexpr double kJitter = 0.05;
    constexpr double kWall = 40.0;  // higher than the pile that is dropped
    Description d;
    d.bodies.push_back(ground(kPitWidth + 4.0, kFriction));
    const double side_at = 0.5 * kPitWidth + 1.0;
    for (const double sign : {-1.0, 1.0}) {
        d.bodies.push_back(fixed_box(
            {2.0, kWall, kPitWidth + 4.0}, {sign * side_at, 0.5 * kWall, 0.0}, kFriction, 0.0));
        d.bodies.push_back(fixed_box(
            {kPitWidth + 4.0, kWall, 2.0}, {0.0, 0.5 * kWall, sign * side_at}, kFriction, 0.0));
    }
    const std::array<Solid, 3> solids{
        Solid::sphere(0.5), Solid::box(Vec3d::Ones()), Solid::capsule(0.4, 0.2)};
    core::Rng rng(3);
    const auto jitter = [&rng] {
        return static_cast<double>(rng.range(-1.0F, 1.0F)) * kJitter;
    };
    for (int y = 0; y < side; ++y) {
        for (int z = 0; z < side; ++z) {
            for (int x = 0; x < side; ++x) {
                const Solid& solid = solids[static_cast<std::size_t>((x + y + z) % 3)];
                const double dx = jitter();
                const double dy = jitter();
                const double dz = jitter();
                const double middle = 0.5 * (side - 1);
                const Vec3d place((x - middle) * kSpacing + dx,
                                  0.8 + y * kSpacing + dy,
                                  (z - middle) * kSpacing + dz);
                d.bodies.push_back(at(solid, solid.volume(), place, kFriction));
            }
        }
    }
    return d;
}

Description resting_field(int side) {
    Description d;
    d.sleeping = true;
    d.bodies.push_back(ground(2.0 * side + 20.0, 0.5));
    const double middle = 0.5 * (side - 1);
    for (int z = 0; z < side; ++z) {
        for (int x = 0; x < side; ++x) {
            const Vec3d place(2.0 * (x - middle), 0.5, 2.0 * (z - middle));
            d.bodies.push_back(at(Solid::box(Vec3d::Ones()), 1.0, place, 0.5));
        }
    }
    return d;
}

Description bounce(double restitution, double seconds, double dt) {
    Description d;
    d.dt = dt;
    d.steps = static_cast<int>(std::lround(seconds / dt));
    d.bodies.push_back(ground(100.0, 0.0, restitution));
    Body ball = at(Solid::sphere(0.5), 1.0, {0.0, kDropHeight + 0.5, 0.0}, 0.0);
    ball.restitution = restitution;
    d.bodies.push_back(ball);
    return d;
}

Description incline(double friction, double seconds) {
    Description d;
    d.steps = static_cast<int>(std::lround(seconds / d.dt));
    const Quatd tilt(Eigen::AngleAxisd(kInclineRadians, Vec3d::UnitZ()));
    const Vec3d normal = tilt * Vec3d::UnitY();
    Body slope = fixed_box({100.0, 2.0, 100.0}, -normal, friction, 0.0);
    slope.pose.orientation = tilt;
    d.bodies.push_back(slope);
    Body cube = at(Solid::box(Vec3d::Ones()), 1.0, 0.5 * normal, friction);
    cube.pose.orientation = tilt;
    d.bodies.push_back(cube);
    return d;
}

Description spin() {
    Description d;
    d.steps = 3600;
    d.gravity = Vec3d::Zero();
    Body body = at(Solid::box({1.0, 2.0, 3.0}), 6.0, Vec3d::Zero(), 0.5);
    body.spin = Vec3d(0.01, 5.0, 0.01);
    d.bodies.push_back(body);
    return d;
}

Description chain() {
    constexpr int kLinks = 20;
    Description d;
    d.colliding = false;
    for (int i = 0; i < kLinks; ++i) {
        d.bodies.push_back(at(Solid::box({1.0, 0.2, 0.2}), 1.0, {i + 0.5, 0.0, 0.0}, 0.5));
        d.joints.push_back({i - 1, i, Vec3d(i, 0.0, 0.0)});
    }
    d.bodies.push_back(at(Solid::sphere(0.5), 100.0, {kLinks + 0.5, 0.0, 0.0}, 0.5));
    d.joints.push_back({kLinks - 1, kLinks, Vec3d(kLinks, 0.0, 0.0)});
    return d;
}

Description bullets() {
    constexpr int kCount = 20;
    constexpr double kSpeed = 500.0;
    Description d;
    d.gravity = Vec3d::Zero();
    d.steps = 60;
    for (int i = 0; i < kCount; ++i) {
        d.bodies.push_back(fixed_box({0.1, 4.0, 4.0}, {0.0, 0.0, 6.0 * i}, 0.5, 0.0));
    }
    for (int i = 0; i < kCount; ++i) {
        const double travel = kSpeed * d.dt;
        Body ball = at(Solid::sphere(0.1), 1.0, {-20.0 - travel * i / kCount, 0.0, 6.0 * i}, 0.5);
        ball.velocity = Vec3d(kSpeed, 0.0, 0.0);
        d.bodies.push_back(ball);
    }
    return d;
}

}  // namespace zoned::scenario
