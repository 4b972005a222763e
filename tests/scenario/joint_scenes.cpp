#include "tests/scenario/joint_scenes.h"

#include "tests/scenario/scene_parts.h"
#include "tests/scenario/solid_geometry.h"
#include "shared/core/rng.h"

#include <cmath>

namespace zoned::scenario {

namespace {

/// Index of the body that is added next.
int next(const Description& d) {
    return static_cast<int>(d.bodies.size());
}

/// A box on four balls that turn about x; its lowest points are `clearance` above y = 0.
void add_wheeled_box(Description& d,
                     double wheel_mass,
                     double wheel_y,
                     double clearance,
                     double friction,
                     double torque) {
    const double y = clearance + kWheelRadius - wheel_y;
    const int box = next(d);
    d.bodies.push_back(at(Solid::box({2.0, 0.5, 4.0}), 1000.0, {0.0, y, 0.0}, friction));
    for (const double x : {-1.3, 1.3}) {
        for (const double z : {-1.4, 1.4}) {
            LinkedPair hinge;
            hinge.a = box;
            hinge.b = next(d);
            hinge.anchor = Vec3d(x, y + wheel_y, z);
            hinge.link = Link::kHinge;
            hinge.motor_torque = torque;
            hinge.motor_speed = torque > 0.0 ? kWheelSpeed : 0.0;
            d.bodies.push_back(at(Solid::sphere(kWheelRadius), wheel_mass, hinge.anchor, friction));
            d.joints.push_back(hinge);
        }
    }
}

double road(double x, double z) {
    return 0.4 * std::sin(0.25 * x) * std::cos(0.2 * z) + 0.15 * std::sin(0.9 * x + 0.7 * z);
}

double bumps(double x, double z) {
    return 0.3 * std::sin(0.7 * x) * std::sin(0.6 * z);
}

Body terrain(Solid solid, double friction) {
    Body body;
    body.solid = std::move(solid);
    body.mass = 0.0;
    body.friction = friction;
    return body;
}

/// Puts one ragdoll together: standing, its feet at `feet`.
class RagdollBuilder {
  public:
    RagdollBuilder(Description& d, const Vec3d& feet) : d_(d), feet_(feet) {}

    void build() {
        const int pelvis = part(0.12, 0.05, 10.0, {0.0, 0.98, 0.0});
        const int chest = part(0.15, 0.10, 20.0, {0.0, 1.28, 0.0});
        const int head = part(0.10, 0.03, 5.0, {0.0, 1.66, 0.0});
        join(pelvis, chest, {0.0, 1.10, 0.0});
        join(chest, head, {0.0, 1.52, 0.0});
        for (const double side : {-1.0, 1.0}) {
            const int upper_arm = part(0.05, 0.10, 2.5, {0.25 * side, 1.27, 0.0});
            const int forearm = part(0.045, 0.10, 1.5, {0.25 * side, 0.97, 0.0});
            const int thigh = part(0.075, 0.145, 7.0, {0.1 * side, 0.68, 0.0});
            const int shin = part(0.06, 0.16, 4.0, {0.1 * side, 0.24, 0.0});
            join(chest, upper_arm, {0.2 * side, 1.42, 0.0});
            join(pelvis, thigh, {0.1 * side, 0.90, 0.0});
            // It faces z: elbows bend forwards, knees backwards.
            bend(upper_arm, forearm, {0.25 * side, 1.12, 0.0}, -Vec3d::UnitX());
            bend(thigh, shin, {0.1 * side, 0.46, 0.0}, Vec3d::UnitX());
        }
    }

  private:
    int part(double radius, double half_segment, double mass, const Vec3d& place) {
        d_.bodies.push_back(at(Solid::capsule(radius, half_segment), mass, feet_ + place, 0.5));
        return next(d_) - 1;
    }

    void join(int a, int b, const Vec3d& place) {
        LinkedPair joint;
        joint.a = a;
        joint.b = b;
        joint.anchor = feet_ + place;
        d_.joints.push_back(joint);
    }

    void bend(int a, int b, const Vec3d& place, const Vec3d& axis) {
        join(a, b, place);
        LinkedPair& joint = d_.joints.back();
        joint.link = Link::kHinge;
        joint.axis = axis;
        joint.limited = true;
        joint.upper = 2.2;
    }

    Description& d_;
    Vec3d feet_;
};

}  // namespace

Description fixed_pair(double ratio) {
    constexpr double kRadius = 0.5;
    Description d;
    d.steps = 300;
    d.bodies.push_back(ground(100.0, 0.5));
    const double low = kPairDrop + kRadius;
    d.bodies.push_back(at(Solid::sphere(kRadius), 1000.0 / ratio, {0.0, low, 0.0}, 0.5));
    d.bodies.push_back(at(Solid::sphere(kRadius), 1000.0, {0.0, low + 2.0 * kRadius, 0.0}, 0.5));
    LinkedPair joint;
    joint.a = 1;
    joint.b = 2;
    joint.anchor = Vec3d(0.0, low + kRadius, 0.0);
    joint.link = Link::kFixed;
    d.joints.push_back(joint);
    return d;
}

Description wheeled_box(double ratio, double height) {
    Description d;
    d.steps = 300;
    d.bodies.push_back(ground(100.0, 0.5));
    add_wheeled_box(d, 1000.0 / ratio, -0.4, height, 0.5, 0.0);
    return d;
}

Description car(bool mesh, int seed) {
    constexpr double kFriction = 0.9;
    constexpr double kWheelY = -0.35;
    Description d;
    d.steps = 1800;
    if (mesh) {
        static const Solid kRoad = solid_terrain(400, 400, 1.0, -200.0, -50.0, road);
        d.bodies.push_back(terrain(kRoad, kFriction));
    } else {
        d.bodies.push_back(ground(1000.0, kFriction));
    }
    add_wheeled_box(d, 20.0, kWheelY, 1.6 + kWheelY - kWheelRadius, kFriction, kWheelTorque);
    core::Rng rng(static_cast<std::uint64_t>(seed));
    for (Body& body : d.bodies) {
        body.mass *= seed > 0 ? 1.0 + 0.2 * static_cast<double>(rng.range(-1.0F, 1.0F)) : 1.0;
    }
    return d;
}

Description ragdolls(int count) {
    constexpr int kSide = 5;
    constexpr double kApart = 2.0;
    Description d;
    d.sleeping = true;
    if (count > 1) {
        d.bodies.push_back(terrain(solid_terrain(40, 40, 1.0, -20.0, -20.0, bumps), 0.5));
    } else {
        d.bodies.push_back(ground(100.0, 0.5));
    }
    const double middle = count > 1 ? 0.5 * (kSide - 1) : 0.0;
    for (int i = 0; i < count; ++i) {
        const Vec3d feet((i % kSide - middle) * kApart,
                         2.0 + i / (kSide * kSide) * kApart,
                         (i / kSide % kSide - middle) * kApart);
        RagdollBuilder(d, feet).build();
    }
    return d;
}

Description sheet(int side) {
    constexpr double kBall = 2.0;
    Description d;
    Body ball = at(Solid::sphere(kBall), 0.0, Vec3d::Zero(), 0.5);
    d.bodies.push_back(ball);
    const double middle = 0.5 * (side - 1);
    for (int z = 0; z < side; ++z) {
        for (int x = 0; x < side; ++x) {
            const Vec3d place((x - middle) * kSheetLink, 3.0, (z - middle) * kSheetLink);
            const int me = next(d);
            d.bodies.push_back(at(Solid::sphere(0.12), 1.0, place, 0.5));
            LinkedPair joint;
            joint.b = me;
            if (x > 0) {
                joint.a = me - 1;
                joint.anchor = place - Vec3d(0.5 * kSheetLink, 0.0, 0.0);
                d.joints.push_back(joint);
            }
            if (z > 0) {
                joint.a = me - side;
                joint.anchor = place - Vec3d(0.0, 0.0, 0.5 * kSheetLink);
                d.joints.push_back(joint);
            }
        }
    }
    return d;
}

}  // namespace zoned::scenario
