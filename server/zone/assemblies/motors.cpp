#include "server/zone/assemblies/motors.h"

#include "server/physics/shapes/ranges.h"
#include "server/zone/assemblies/assembly_spawning.h"
#include "server/zone/assemblies/entity_joints.h"
#include "shared/core/elementary/elementary.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace zoned::zone {

namespace {

/// A motor that holds a position makes up this share of what is left in each tick.
constexpr float kShareOfTick = 0.25F;
/// It rests within the first, and moves again beyond the second, m or rad.
constexpr float kReached = 2e-4F;
constexpr float kStraysFrom = 1e-3F;
/// A change of speed that is worth waking sleeping bodies for, as a share of the greatest.
constexpr float kWorthTelling = 1e-4F;
constexpr float kFullStick = 127.0F;

double time_of(const ZoneState& state) {
    return static_cast<double>(state.now) * static_cast<double>(state.settings.dt);
}

float left_to_go(const ZoneState& state, const EntityJoint& joint) {
    const float left = joint.target - state.scene.joint_position(joint.joint);
    const physics::JointDef& def = joint.plan->def;
    if (def.kind != physics::JointKind::kHinge || def.limited) {
        return left;
    }
    return std::remainder(left, 2.0F * std::numbers::pi_v<float>);
}

float speed_towards(const ZoneState& state, const EntityJoint& joint) {
    const float left = left_to_go(state, joint);
    if (std::abs(left) < (joint.speed == 0.0F ? kStraysFrom : kReached)) {
        return 0.0F;
    }
    return std::clamp(kShareOfTick * left / state.settings.dt, -joint.max_speed, joint.max_speed);
}

/// Tells the scene the speed for the coming step.
void lead(ZoneState& state, EntityJoint& joint) {
    const float speed = joint.holds_position ? speed_towards(state, joint) : joint.target;
    const float least = kWorthTelling * (joint.holds_position ? joint.max_speed : 1.0F);
    const bool stops = speed == 0.0F && joint.speed != 0.0F;
    if (!stops && std::abs(speed - joint.speed) <= least) {
        return;
    }
    if (state.scene.set_motor(joint.joint, speed, joint.most)) {
        joint.speed = speed;
        state.assemblies.changed.push_back(joint.id);
    }
}

/// The stick along the axes of what carries the driver, -1..1.
Vec2 stick_of(const ZoneState& state, const Rider& rider) {
    const world::Entities& e = state.entities;
    const world::Row row = e.find(rider.rider);
    const world::Row carrier = e.find(rider.carrier);
    const motion::InputCommand& command = e.command[row];
    const Vec3 wanted(static_cast<float>(command.move_x) / kFullStick,
                      0.0F,
                      static_cast<float>(command.move_z) / kFullStick);
    const auto share = [&](const Vec3& axis) {
        const Vec3 level = e.orientation[carrier] * axis;
        const float length = elementary::hypot(level.x(), level.z());
        return length > 1e-3F ? std::clamp(level.dot(wanted) / length, -1.0F, 1.0F) : 0.0F;
    };
    return {share(Vec3::UnitZ()), share(Vec3::UnitX())};
}

void set_controls(ZoneState& state, EntityId root, const Vec2& stick) {
    const AssemblyDef* assembly = assembly_of(state, root);
    if (assembly == nullptr) {
        return;
    }
    for (const AssemblyControl& control : assembly->controls) {
        if (EntityJoint* joint = find_joint(state, joint_numbered(state, {root, control.joint}))) {
            const float target = control.value * (control.sideways ? stick.y() : stick.x());
            if (target != joint->target || !joint->by_hand) {
                set_motor_target(state, *joint, target);
            }
        }
    }
}

}  // namespace

void begin_motor(ZoneState& state, EntityJoint& joint) {
    if (!joint.plan->motor) {
        return;
    }
    const MotorDef& motor = *joint.plan->motor;
    joint.motor = true;
    joint.holds_position = motor.holds_position;
    joint.target = motor.target.at(time_of(state));
    joint.most = motor.most;
    joint.max_speed = motor.max_speed;
    joint.speed = motor.holds_position ? 0.0F : joint.target;
    state.scene.set_motor(joint.joint, joint.speed, joint.most);
}

std::uint32_t moving_motors(const ZoneState& state) {
    std::uint32_t moving = 0;
    const double time = time_of(state);
    for (const EntityJointId id : state.assemblies.motors) {
        const EntityJoint& joint = *find_joint(state, id);
        moving += !joint.by_hand && joint.plan->motor->target.changes_after(time) ? 1U : 0U;
    }
    return moving;
}

std::uint32_t follow_motors(ZoneState& state) {
    for (const Rider& rider : state.assemblies.riders) {
        if (rider.drives && state.entities.find(rider.rider) != world::kNoRow) {
            set_controls(state, rider.drives, stick_of(state, rider));
        }
    }
    const double time = time_of(state);
    for (const EntityJointId id : state.assemblies.motors) {
        EntityJoint& joint = *find_joint(state, id);
        if (!joint.by_hand) {
            joint.target = joint.plan->motor->target.at(time);
        }
        lead(state, joint);
    }
    return static_cast<std::uint32_t>(state.assemblies.motors.size());
}

bool set_motor_target(ZoneState& state, EntityJoint& joint, float target) {
    if (!joint.motor || !physics::fit_motor(target, joint.most)) {
        return false;
    }
    joint.target = target;
    joint.by_hand = true;
    state.assemblies.changed.push_back(joint.id);
    lead(state, joint);
    return true;
}

void release_controls(ZoneState& state, EntityId root) {
    set_controls(state, root, Vec2::Zero());
}

}  // namespace zoned::zone
