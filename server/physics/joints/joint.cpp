#include "server/physics/joints/joint.h"

#include "server/physics/shapes/ranges.h"

#include <numbers>

namespace zoned::physics {

namespace {

/// Empty where cone and twist of a ball joint are within their ranges.
std::string why_unfit_ball(const JointDef& def) {
    const bool coned = def.cone_rad != 0.0F;
    if (coned && !within(def.cone_rad, kNarrowestCone, std::numbers::pi_v<float>)) {
        return "joint: cone out of range";
    }
    if (!def.cone_axis.isZero(0.0F) && !within(def.cone_axis.norm(), 1.0e-6F, 1.0e6F)) {
        return "joint: cone axis has no direction";
    }
    if (def.limited && !(coned && def.cone_rad <= kWidestTwistCone)) {
        return "joint: a twist is limited within a cone of at most 150 degrees";
    }
    return {};
}

}  // namespace

std::string why_unfit(const JointDef& def) {
    if (static_cast<unsigned>(def.kind) > static_cast<unsigned>(JointKind::kSpring)) {
        return "unknown joint kind";
    }
    if (!fit_position(def.anchor) || !fit_position(def.anchor_b)) {
        return "joint: anchor out of range";
    }
    if (!within(def.axis.norm(), 1.0e-6F, 1.0e6F)) {
        return "joint: axis has no direction";
    }
    if (!(def.length_m <= kMaxSize)) {
        return "joint: length out of range";
    }
    if (!within(def.spring_hz, 0.0F, 1000.0F) || !within(def.spring_damping_ratio, 0.0F, 1000.0F)) {
        return "joint: spring frequency or damping out of range";
    }
    if (def.kind == JointKind::kBall) {
        if (std::string reason = why_unfit_ball(def); !reason.empty()) {
            return reason;
        }
    }
    if (def.limited) {
        // An angle is known up to half a turn in either direction.
        const bool turns = def.kind == JointKind::kHinge || def.kind == JointKind::kBall;
        const float most = turns ? std::numbers::pi_v<float> : kMaxSize;
        if (def.lower > def.upper) {
            return "joint: lower limit above the upper one";
        }
        if (!(def.lower <= most && def.upper >= -most)) {
            return "joint: limit out of range";
        }
    }
    if (def.motor && !fit_motor(def.motor_speed, def.motor_max)) {
        return "joint: motor speed or greatest force out of range";
    }
    if (!(def.break_force_n > 0.0F)) {
        return "joint: force to break at must be positive";
    }
    return {};
}

}  // namespace zoned::physics
