#include "tests/scenario/impact_scenes.h"

#include "tests/scenario/scene_parts.h"

#include <cmath>
#include <numbers>

namespace zoned::scenario {

namespace {

Body smooth_ball(double radius, double mass, const Vec3d& place, double restitution) {
    Body ball = at(Solid::sphere(radius), mass, place, 0.0);
    ball.restitution = restitution;
    return ball;
}

}  // namespace

Description row_of_balls(int count, double gap, double restitution) {
    Description d;
    d.gravity = Vec3d::Zero();
    d.steps = 120;
    for (int i = 0; i < count; ++i) {
        d.bodies.push_back(smooth_ball(0.5, 1.0, {i * (1.0 + gap), 0.0, 0.0}, restitution));
    }
    d.bodies.front().velocity = Vec3d(kRowSpeed, 0.0, 0.0);
    return d;
}

Description cradle() {
    constexpr double kRod = 3.0;
    const double angle = 40.0 / 180.0 * std::numbers::pi;
    Description d;
    d.steps = 1200;
    for (int i = 0; i < 5; ++i) {
        LinkedPair rod;
        rod.b = i;
        rod.anchor = Vec3d(i, kRod, 0.0);
        d.joints.push_back(rod);
        d.bodies.push_back(smooth_ball(0.5, 1.0, Vec3d(i, 0.0, 0.0), 1.0));
    }
    d.bodies.front().pose.position =
        d.joints.front().anchor - kRod * Vec3d(std::sin(angle), std::cos(angle), 0.0);
    return d;
}

Description billiard_break(double restitution) {
    constexpr double kRadius = 0.028575;
    constexpr double kMass = 0.17;
    constexpr double kApart = 2.0 * kRadius + 1e-4;
    Description d;
    d.gravity = Vec3d::Zero();
    d.steps = 120;
    d.bodies.push_back(smooth_ball(kRadius, kMass, {-0.3, 0.0, 0.002}, restitution));
    d.bodies.front().velocity = Vec3d(5.0, 0.0, 0.0);
    for (int row = 0; row < 5; ++row) {
        for (int i = 0; i <= row; ++i) {
            const Vec3d place(0.5 * std::sqrt(3.0) * kApart * row, 0.0, kApart * (i - 0.5 * row));
            d.bodies.push_back(smooth_ball(kRadius, kMass, place, restitution));
        }
    }
    return d;
}

Description house_of_cards(const CardHouse& house) {
    constexpr int kStoreys = 5;
    constexpr double kHalfLength = 0.6;
    constexpr double kMass = 0.2;
    const double lean = 20.0 / 180.0 * std::numbers::pi;
    const double t = house.half_thickness;
    const Solid plate = Solid::box({2.0 * t, 2.0 * kHalfLength, 0.8});
    // Half the height and width of a leaning plate. The tops of a pair meet in an edge.
    const double half_height = kHalfLength * std::cos(lean) + t * std::sin(lean);
    const double half_width = kHalfLength * std::sin(lean) + t * std::cos(lean);
    const double apart = 2.0 * kHalfLength + 1e-3;  // plates across lie end to end
    Description d;
    d.dt = house.dt;
    d.steps = static_cast<int>(std::lround(20.0 / house.dt));
    d.bodies.push_back(ground(100.0, house.friction));
    d.bodies.front().pose.position.x() = house.x;
    const auto add = [&](double x, double y, double angle) {
        d.bodies.push_back(at(plate, kMass, {house.x + x, y, 0.0}, house.friction));
        d.bodies.back().pose.orientation = Quatd(Eigen::AngleAxisd(angle, Vec3d::UnitZ()));
    };
    double y = 0.0;
    for (int storey = 0; storey < kStoreys; ++storey) {
        const int pairs = kStoreys - storey;
        const double first = -0.5 * (pairs - 1) * apart;
        for (int i = 0; i < pairs; ++i) {
            const double x = first + i * apart;
            add(x - half_width, y + half_height, -lean);
            add(x + half_width, y + half_height, lean);
        }
        for (int i = 0; i + 1 < pairs; ++i) {
            add(first + (i + 0.5) * apart, y + 2.0 * half_height + t, 0.5 * std::numbers::pi);
        }
        y += 2.0 * (half_height + t);
    }
    return d;
}

}  // namespace zoned::scenario
