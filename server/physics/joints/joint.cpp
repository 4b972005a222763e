#include "server/physics/joints/joint.h"

#include "server/physics/shapes/ranges.h"

#include <numbers>

namespace zoned::physics {

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
    if (def.limited) {
        // A hinge knows its angle up to half a turn in either direction.
        const float most = def.kind == JointKind::kHinge ? std::numbers::pi_v<float> : kMaxSize;
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
