// build: hot loops
#include "server/physics/joints/joint_rows.h"

#include "shared/core/elementary/elementary.h"
#include "shared/math/perpendicular.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace zoned::physics {

namespace {

/// The part that all rows of a joint share.
struct Placement {
    Vec3 arm_a, arm_b;  ///< from the centres to the anchors, world
    Vec3 gap;           ///< from a's anchor to b's
    Mat3 axes_a, axes_b;
};

bool has_axes(const JointDef& def) {
    switch (def.kind) {
        case JointKind::kHinge:
        case JointKind::kSlider:
        case JointKind::kFixed:
            return true;
        case JointKind::kBall:
            return def.cone_rad > 0.0F;
        case JointKind::kDistance:
        case JointKind::kSpring:
            break;
    }
    return false;
}

void place_axes(const Joint& joint, const JointPose& a, const JointPose& b, Placement& p) {
    p.axes_a = a.rotation * joint.axes_a;
    p.axes_b = b.rotation * joint.axes_b;
}

Placement place(const Joint& joint, const JointPose& a, const JointPose& b) {
    Placement p;
    p.arm_a = a.rotation * joint.local_a;
    p.arm_b = b.rotation * joint.local_b;
    p.gap = (b.position - a.position) + (p.arm_b - p.arm_a);
    if (has_axes(joint.def)) {
        place_axes(joint, a, b, p);
    }
    return p;
}

/// The gap along its own direction: C = |gap|.
void point_row(const Placement& p, const Vec3& n, float error, JointRow& row) {
    row.linear = n;
    row.angular_a = -p.arm_a.cross(n);
    row.angular_b = p.arm_b.cross(n);
    row.error = error;
}

/// The gap along a direction that turns with a: C = n . gap, C' = ... + w_a . (n x gap).
void shift_row(const Placement& p, const Vec3& n, float error, JointRow& row) {
    row.linear = n;
    row.angular_a = -(p.arm_a + p.gap).cross(n);
    row.angular_b = p.arm_b.cross(n);
    row.error = error;
}

/// Two directions at right angles, u of a and w of b: C = u . w.
void angle_row(const Vec3& u, const Vec3& w, JointRow& row) {
    row.angular_b = w.cross(u);
    row.angular_a = -row.angular_b;
    row.error = u.dot(w);
}

/// Along a's own axes: the impulse then acts on both bodies at one point, b's anchor, so that no
/// gap turns it into a moment out of nothing.
void ball_rows(const JointPose& a, const Placement& p, JointRows& out) {
    for (int i = 0; i < 3; ++i) {
        const Vec3 n = a.rotation.col(i);
        shift_row(p, n, n.dot(p.gap), out.add(RowKind::kHard));
    }
}

/// b's axis stays at right angles to the two that stand across a's.
void axis_rows(const Placement& p, JointRows& out) {
    angle_row(p.axes_a.col(1), p.axes_b.col(0), out.add(RowKind::kHard));
    angle_row(p.axes_a.col(2), p.axes_b.col(0), out.add(RowKind::kHard));
}

void lock_rows(const Placement& p, JointRows& out) {
    axis_rows(p, out);
    angle_row(p.axes_a.col(1), p.axes_b.col(2), out.add(RowKind::kHard));
}

float hinge_angle(const Placement& p) {
    return elementary::atan2(p.axes_a.col(2).dot(p.axes_b.col(1)),
                             p.axes_a.col(1).dot(p.axes_b.col(1)));
}

/// The angle as the limits count it: half a turn past them the nearer one holds, so that a hinge
/// pushed over the far side is not thrown right through its range.
float nearest_turn(float angle, const JointDef& def) {
    constexpr float kTurn = 2.0F * std::numbers::pi_v<float>;
    const float middle = 0.5F * (def.lower + def.upper);
    return angle + kTurn * std::round((middle - angle) / kTurn);
}

float swing_of(const Placement& p) {
    const Vec3 u = p.axes_a.col(0);
    const Vec3 w = p.axes_b.col(0);
    return elementary::atan2(u.cross(w).norm(), u.dot(w));
}

/// The turn between the two, as a quaternion, is a twist about the axis of a followed by a swing
/// about a line across it. The twist is 2 atan2(x, w) then, with x along the axis (P. Baerlocher,
/// R. Boulic, "Parametrization and range of motion of the ball-and-socket joint", 2001). Here it is
/// read off the rotation matrix.
float twist_of(const Placement& p) {
    return elementary::atan2(
        p.axes_a.col(2).dot(p.axes_b.col(1)) - p.axes_a.col(1).dot(p.axes_b.col(2)),
        p.axes_a.col(1).dot(p.axes_b.col(1)) + p.axes_a.col(2).dot(p.axes_b.col(2)));
}

/// b's axis stays within the cone: C = cone - angle. Where the axis is in the cone's middle, or
/// straight behind it, it leaves or returns in any direction.
void cone_row(const Placement& p, float cone, JointRow& row) {
    const Vec3 across = p.axes_a.col(0).cross(p.axes_b.col(0));
    const float sine = across.norm();
    const Vec3 n = sine > 1.0e-6F ? Vec3(across / sine) : Vec3(p.axes_a.col(1));
    row.angular_a = n;
    row.angular_b = -n;
    row.error = cone - swing_of(p);
}

/// With u and w the axes of a and b, the twist changes by (w_b - w_a) . (u + w) / (1 + u . w). That
/// grows without bound where b points straight back: impacts may push it there, and there the row
/// gives way instead of spinning the limb.
void twist_row(const Placement& p, float sign, float error, JointRow& row) {
    const Vec3 sum = p.axes_a.col(0) + p.axes_b.col(0);
    row.angular_b = (sign / std::max(0.5F * sum.squaredNorm(), 0.1F)) * sum;
    row.angular_a = -row.angular_b;
    row.error = error;
}

/// Turning about, or moving along, the free axis of a hinge or slider.
void free_row(const Joint& joint, const Placement& p, float sign, float error, JointRow& row) {
    if (joint.def.kind == JointKind::kHinge) {
        // The angle is that of u = b's first cross axis as seen along a's axis: where u leans
        // along the axis by x, turning about u's projection q moves the angle by x / |q|^2.
        const Vec3 u = p.axes_b.col(1);
        const float x = p.axes_a.col(0).dot(u);
        const Vec3 q = u - x * p.axes_a.col(0);
        row.angular_b = sign * (p.axes_a.col(0) - (x / std::max(q.squaredNorm(), 0.1F)) * q);
        row.angular_a = -row.angular_b;
        row.error = error;
    } else {
        shift_row(p, sign * p.axes_a.col(0), error, row);
    }
}

/// Cone and twist. They come before friction, whose rows may come and go.
void ball_limits(const Joint& joint, const Placement& p, JointRows& out) {
    const JointDef& def = joint.def;
    if (def.cone_rad > 0.0F) {
        cone_row(p, def.cone_rad, out.add(RowKind::kLimit));
    }
    if (def.limited && def.cone_rad > 0.0F) {
        const float at = nearest_turn(twist_of(p), def);
        twist_row(p, 1.0F, at - def.lower, out.add(RowKind::kLimit));
        twist_row(p, -1.0F, def.upper - at, out.add(RowKind::kLimit));
    }
}

/// Friction about all three axes of a; each has the whole torque to itself.
void friction_rows(const Joint& joint, const JointPose& a, JointRows& out) {
    for (int i = 0; joint.def.motor && i < 3; ++i) {
        JointRow& row = out.add(RowKind::kMotor);
        row.angular_b = a.rotation.col(i);
        row.angular_a = -row.angular_b;
        row.most = joint.def.motor_max;
    }
}

void free_axis_rows(const Joint& joint, const Placement& p, JointRows& out) {
    const JointDef& def = joint.def;
    if (def.motor) {
        JointRow& row = out.add(RowKind::kMotor);
        free_row(joint, p, 1.0F, 0.0F, row);
        row.target = def.motor_speed;
        row.most = def.motor_max;
    }
    if (def.limited) {
        const float at = def.kind == JointKind::kHinge ? nearest_turn(hinge_angle(p), def)
                                                       : p.axes_a.col(0).dot(p.gap);
        free_row(joint, p, 1.0F, at - def.lower, out.add(RowKind::kLimit));
        free_row(joint, p, -1.0F, def.upper - at, out.add(RowKind::kLimit));
    }
}

/// The shortest turn from one unit vector to another.
Mat3 shortest_turn(const Vec3& from, const Vec3& to) {
    const float cosine = from.dot(to);
    if (cosine < -0.9999F) {
        const Vec3 about = any_perpendicular(from);
        return 2.0F * about * about.transpose() - Mat3::Identity();
    }
    const Vec3 k = from.cross(to);
    Mat3 cross;
    cross << 0.0F, -k.z(), k.y(), k.z(), 0.0F, -k.x(), -k.y(), k.x(), 0.0F;
    return Mat3::Identity() + cross + cross * cross / (1.0F + cosine);
}

void distance_row(const Joint& joint, const Placement& p, JointRow& row) {
    const float distance = p.gap.norm();
    const Vec3 n = distance > 1.0e-6F ? Vec3(p.gap / distance) : Vec3(Vec3::UnitY());
    point_row(p, n, distance - joint.length, row);
}

}  // namespace

SpringConstants spring_constants(const JointDef& def, double inverse_mass) {
    if (!(inverse_mass > 0.0)) {
        return {};
    }
    const double omega = 2.0 * std::numbers::pi * static_cast<double>(def.spring_hz);
    const double mass = 1.0 / inverse_mass;
    return {mass * omega * omega,
            2.0 * mass * static_cast<double>(def.spring_damping_ratio) * omega};
}

Joint make_joint(const JointDef& def, const JointPose& a, const JointPose& b) {
    const bool two_points = def.kind == JointKind::kDistance || def.kind == JointKind::kSpring;
    Joint joint;
    joint.def = def;
    const Vec3 on_b = two_points ? def.anchor_b : def.anchor;
    joint.local_a = a.rotation.transpose() * (def.anchor - a.position);
    joint.local_b = b.rotation.transpose() * (on_b - b.position);
    Mat3 axes;
    axes.col(0) = def.axis.normalized();
    int least = 0;
    axes.col(0).cwiseAbs().minCoeff(&least);
    axes.col(1) = axes.col(0).cross(Vec3::Unit(least)).normalized();
    axes.col(2) = axes.col(0).cross(axes.col(1));
    joint.axes_b = b.rotation.transpose() * axes;
    if (!def.cone_axis.isZero(0.0F)) {  // as placed, b has swung out of its middle without a twist
        axes = Mat3(shortest_turn(axes.col(0), def.cone_axis.normalized()) * axes);
    }
    joint.axes_a = a.rotation.transpose() * axes;
    joint.length = def.length_m >= 0.0F ? def.length_m : (on_b - def.anchor).norm();
    return joint;
}

std::size_t hard_rows(JointKind kind) {
    switch (kind) {
        case JointKind::kBall:
            return 3;
        case JointKind::kHinge:
        case JointKind::kSlider:
            return 5;
        case JointKind::kFixed:
            return 6;
        case JointKind::kDistance:
            return 1;
        case JointKind::kSpring:
            return 0;
    }
    return 0;
}

void write_rows(const Joint& joint, const JointPose& a, const JointPose& b, JointRows& out) {
    const Placement p = place(joint, a, b);
    out.count = 0;
    switch (joint.def.kind) {
        case JointKind::kBall:
            ball_rows(a, p, out);
            ball_limits(joint, p, out);
            friction_rows(joint, a, out);
            break;
        case JointKind::kHinge:
            ball_rows(a, p, out);
            axis_rows(p, out);
            break;
        case JointKind::kSlider:
            lock_rows(p, out);
            for (int i = 1; i < 3; ++i) {
                const Vec3 across = p.axes_a.col(i);
                shift_row(p, across, across.dot(p.gap), out.add(RowKind::kHard));
            }
            break;
        case JointKind::kFixed:
            ball_rows(a, p, out);
            lock_rows(p, out);
            break;
        case JointKind::kDistance:
            distance_row(joint, p, out.add(RowKind::kHard));
            break;
        case JointKind::kSpring:
            distance_row(joint, p, out.add(RowKind::kSpring));
            out.rows[0].spring = &joint.def;
            break;
    }
    if (joint.def.kind == JointKind::kHinge || joint.def.kind == JointKind::kSlider) {
        free_axis_rows(joint, p, out);
    }
}

float swing_angle(const Joint& joint, const JointPose& a, const JointPose& b) {
    Placement p;
    place_axes(joint, a, b, p);
    return swing_of(p);
}

float twist_angle(const Joint& joint, const JointPose& a, const JointPose& b) {
    Placement p;
    place_axes(joint, a, b, p);
    return twist_of(p);
}

float joint_position(const Joint& joint, const JointPose& a, const JointPose& b) {
    const Placement p = place(joint, a, b);
    switch (joint.def.kind) {
        case JointKind::kHinge:
            return hinge_angle(p);
        case JointKind::kSlider:
            return p.axes_a.col(0).dot(p.gap);
        default:
            return p.gap.norm();
    }
}

}  // namespace zoned::physics
