// PhysicsScenes: rigid-body scenes described apart from any engine, for ours and its peers.
#pragma once

#include "shared/math/types.h"

#include <cstdint>
#include <memory>
#include <vector>

namespace zoned::scenario {

using Quatd = Eigen::Quaternion<double, Eigen::DontAlign>;

enum class Form : std::uint8_t {
    kSphere,
    kBox,
    kCapsule,
    kHull,
    kCompound,
    kMesh,  ///< a surface; static bodies only
};

struct SolidGeometry;

/// A solid in its own principal axes, centred on its centre of mass.
struct Solid {
    Form form = Form::kBox;
    Vec3d half_extents = Vec3d::Constant(0.5);  ///< box, m
    double radius = 0.5;                        ///< sphere, capsule, m
    double half_segment = 0.0;                  ///< capsule, along its y axis, m
    /// The other forms, see solid_geometry.h; shared by all solids of that form.
    std::shared_ptr<const SolidGeometry> geometry;

    static Solid sphere(double radius);
    /// `size` is the full size.
    static Solid box(const Vec3d& size);
    static Solid capsule(double radius, double half_segment);

    bool operator==(const Solid&) const = default;

    [[nodiscard]] double volume() const;  ///< m3; 0 for a mesh
    /// Principal moments about the centre of mass for uniform density and one kilogram, m2.
    [[nodiscard]] Vec3d inertia_per_mass() const;
};

/// Where a solid is.
struct Pose {
    Vec3d position = Vec3d::Zero();
    Quatd orientation = Quatd::Identity();
};

struct Body {
    Solid solid;
    double mass = 1.0;  ///< kg; 0: static
    double friction = 0.5;
    double restitution = 0.0;
    /// A level static box that everything stays above: an engine may take it for a half-space.
    bool ground = false;
    Pose pose;
    Vec3d velocity = Vec3d::Zero();  ///< m/s
    Vec3d spin = Vec3d::Zero();      ///< rad/s, world axes
};

/// The world as a partner of a joint.
inline constexpr int kWorld = -1;

enum class Link : std::uint8_t {
    kBall,   ///< a point of a stays on a point of b
    kHinge,  ///< and they turn about one axis only
    kFixed,  ///< and they do not turn
};

/// Joins two bodies, which do not collide with each other.
struct LinkedPair {
    int a = kWorld;                ///< index of a body, or kWorld
    int b = 0;                     ///< index of a body
    Vec3d anchor = Vec3d::Zero();  ///< world point at the start, m
    Link link = Link::kBall;
    Vec3d axis = Vec3d::UnitX();  ///< hinge: world, unit length
    /// Hinge: the angle of b against a about the axis, from the start, rad.
    bool limited = false;
    double lower = 0.0;
    double upper = 0.0;
    /// Hinge: the motor turns b against a with at most this torque, N m; 0: none.
    double motor_torque = 0.0;
    double motor_speed = 0.0;  ///< rad/s
};

/// A scene at its start and how it is stepped.
struct Description {
    std::vector<Body> bodies;
    std::vector<LinkedPair> joints;
    Vec3d gravity = Vec3d(0.0, -9.81, 0.0);  ///< m/s2
    double dt = 1.0 / 60.0;                  ///< s
    int steps = 600;
    bool sleeping = false;      ///< bodies may fall asleep
    bool colliding = true;      ///< bodies collide with each other
    int first_dynamic() const;  ///< index of the first body that is not static
};

/// S1: 20 rows of unit boxes, 210 in all.
Description pyramid();
/// S2: `count` unit cubes one on the other, mass 1 but for the top one. S2x100: column(5, 100).
Description column(int count, double top_mass);
/// S3: side^3 mixed bodies above a pit whose floor is `kPitWidth` wide.
Description pile(int side);
inline constexpr double kPitWidth = 24.0;  ///< m
/// S4: `side`^2 unit boxes on the ground, 2 m apart.
Description resting_field(int side);
/// S5: a sphere dropped from a clearance of 10 m.
Description bounce(double restitution, double seconds, double dt);
inline constexpr double kDropHeight = 10.0;  ///< m
/// S6: a unit cube on an incline of 30 degrees.
Description incline(double friction, double seconds);
inline constexpr double kInclineRadians = 0.52359877559829887;
/// S7: a box that turns about its middle axis, no gravity.
Description spin();
/// S8: 20 boxes on ball joints with a heavy sphere at the end.
Description chain();
/// S9: 20 fast spheres, each towards a thin wall of its own whose middle is at x = 0.
Description bullets();

}  // namespace zoned::scenario
