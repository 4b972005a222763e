// AssemblyDef: a type of several bodies, as the config describes it: parts, joints, motors, seats,
// controls.
#pragma once

#include "server/physics/joints/joint.h"
#include "shared/core/ids.h"
#include "shared/math/types.h"

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace zoned::zone {

/// The target of a motor: a number, or a function of the world's time.
struct MotorTarget {
    enum class Form : std::uint8_t {
        kConstant,
        kSine,   ///< mean + amplitude sin(2 pi t / period + phase)
        kRamps,  ///< straight lines between points
    };

    struct RampPoint {
        double at_s = 0.0;
        float value = 0.0F;
    };

    Form form = Form::kConstant;
    float mean = 0.0F;  ///< kConstant: the value
    float amplitude = 0.0F;
    double period_s = 0.0;          ///< kRamps: 0 = the points do not repeat
    double phase_rad = 0.0;         ///< kSine
    std::vector<RampPoint> points;  ///< kRamps: at least one, ascending in time

    /// At a time since the world's first tick, s >= 0.
    [[nodiscard]] float at(double time_s) const;
    /// Whether the value still changes at some later time.
    [[nodiscard]] bool changes_after(double time_s) const;
};

/// The motor of a hinge (rad/s, rad, N m) or slider (m/s, m, N).
struct MotorDef {
    bool holds_position = false;  ///< the target is an angle or a shift, else a speed
    MotorTarget target;
    float most = 0.0F;       ///< torque or force
    float max_speed = 0.0F;  ///< holds_position: it approaches its target no faster
};

/// A joint as it is written down, in the axes of body b. Angles and shifts count from the poses at
/// which the joint is made.
struct JointPlan {
    std::string name;
    /// Without bodies. `anchor`: on a; of distance and spring in the axes of a (or of b as placed
    /// where the world takes a's part). `anchor_b`, and `anchor` of the other kinds: on b, from its
    /// centre, along its axes, as is `axis`.
    physics::JointDef def;
    std::optional<MotorDef> motor;
};

/// A part that stands for the world.
inline constexpr std::uint16_t kWorldPart = 0xFFFF;

struct AssemblyJoint {
    std::shared_ptr<const JointPlan> plan;
    std::uint16_t a = kWorldPart;  ///< parts
    std::uint16_t b = 0;
};

struct AssemblyPart {
    std::string name;
    TypeIndex type = 0;
    Vec3 position = Vec3::Zero();  ///< of its centre, from the root's centre along the root's axes
    Quat orientation = Quat::Identity();  ///< against the root
};

struct AssemblySeat {
    std::uint16_t part = 0;
    Vec3 place = Vec3::Zero();  ///< of the rider's centre, from the part's, along its axes, m
};

struct AssemblyControl {
    std::uint16_t joint = 0;
    bool sideways = false;  ///< by the share of the stick along the seat's x axis, else its z axis
    float value = 0.0F;     ///< target of the motor at the full stick
};

struct AssemblyDef {
    std::vector<AssemblyPart> parts;  ///< at least one; the first is the root
    std::vector<AssemblyJoint> joints;
    std::vector<AssemblySeat> seats;  ///< the rider on the first one drives
    std::vector<AssemblyControl> controls;
};

/// By EntityType::assembly - 1.
using AssemblyTable = std::vector<AssemblyDef>;

}  // namespace zoned::zone
