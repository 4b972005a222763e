// Rows of joints: each joint as constraints C' = J V with limits, the form that all solvers share.
#pragma once

#include "server/physics/joints/joint.h"

#include <array>
#include <cstddef>

namespace zoned::physics {

/// The geometry of a joint: places and axes in the bodies' own coordinates.
struct Joint {
    JointDef def;
    Vec3 local_a = Vec3::Zero();  ///< anchor in a's coordinates, from its centre of mass
    Vec3 local_b = Vec3::Zero();
    Mat3 axes_a = Mat3::Identity();  ///< columns: the joint's axis (cone's) and two across it
    Mat3 axes_b = Mat3::Identity();
    float length = 0.0F;  ///< rest length, m
};

/// Where a body is, relative to some point common to both.
struct JointPose {
    Vec3 position = Vec3::Zero();
    Mat3 rotation = Mat3::Identity();
};

enum class RowKind : std::uint8_t {
    kHard,    ///< C = 0
    kLimit,   ///< C >= 0, impulse >= 0
    kMotor,   ///< C' = target, |impulse| <= most h
    kSpring,  ///< soft
};

/// C' = linear . (v_b - v_a) + angular_a . w_a + angular_b . w_b. A positive impulse pushes b along
/// `linear`.
struct JointRow {
    Vec3 linear = Vec3::Zero();
    Vec3 angular_a = Vec3::Zero();
    Vec3 angular_b = Vec3::Zero();
    float error = 0.0F;                ///< C, m or rad
    float target = 0.0F;               ///< motor: speed wanted
    float most = 0.0F;                 ///< motor: force or torque
    const JointDef* spring = nullptr;  ///< spring: where its constants are
    RowKind kind = RowKind::kHard;
};

/// Rows that a joint has at most: those of a ball joint with cone, twist and friction. Three bind,
/// one is the cone, two bound the twist, three are friction.
inline constexpr std::size_t kMostRows = 9;

struct JointRows {
    std::array<JointRow, kMostRows> rows;
    std::size_t count = 0;

    JointRow& add(RowKind kind) {
        JointRow& row = rows[count++];
        row = JointRow();
        row.kind = kind;
        return row;
    }
};

/// A spring's force along the line between its points is -k x - c x'.
struct SpringConstants {
    double k = 0.0;  ///< N/m
    double c = 0.0;  ///< N s/m
};

/// The constants that give two free bodies, tied at their centres, the frequency and damping asked
/// for. `inverse_mass`: the sum of the bodies' own, 1/kg; 0 (nothing moves): no force. The
/// constants stay fixed while arms turn: a stiffness that followed the effective mass at the
/// anchors would give back more than went in.
SpringConstants spring_constants(const JointDef& def, double inverse_mass);

/// The joint between bodies at these poses, as its definition places it.
Joint make_joint(const JointDef& def, const JointPose& a, const JointPose& b);

/// How far a ball joint's axis is from the middle of its cone, rad 0..pi.
float swing_angle(const Joint& joint, const JointPose& a, const JointPose& b);

/// Turn of a ball joint's b about its axis, rad in (-pi, pi]: what is left of the turn against a
/// once b's axis has been swung straight back to the middle of the cone.
float twist_angle(const Joint& joint, const JointPose& a, const JointPose& b);

/// How many hard rows a joint has: always the same, and they come first.
std::size_t hard_rows(JointKind kind);

/// All rows of a joint at the given poses.
void write_rows(const Joint& joint, const JointPose& a, const JointPose& b, JointRows& out);

/// Angle of a hinge from where it was made, rad in (-pi, pi]; shift of a slider, m; distance of the
/// anchors of the others, m.
float joint_position(const Joint& joint, const JointPose& a, const JointPose& b);

}  // namespace zoned::physics
