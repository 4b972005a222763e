// Joints, assemblies, forces and riders as the rules see them.
#include "server/zone/assemblies/assembly_spawning.h"
#include "server/zone/assemblies/entity_joints.h"
#include "server/zone/assemblies/motors.h"
#include "server/zone/assemblies/riding.h"
#include "server/zone/context/zone_context.h"
#include "server/zone/simulation/approaching_props.h"

#include <algorithm>

namespace zoned::zone {

void ZoneContext::parts_of(EntityId root, std::vector<EntityId>& out) const {
    out.clear();
    const AssemblyDef* assembly = assembly_of(*state_, root);
    const std::size_t count = assembly != nullptr ? assembly->parts.size() : 1;
    for (std::size_t p = 0; p < count; ++p) {
        const EntityId part = part_id(*state_, root, static_cast<std::uint16_t>(p));
        if (owned(part) != world::kNoRow) {
            out.push_back(part);
        }
    }
}

EntityId ZoneContext::assembly_root(EntityId part) const {
    return root_of(*state_, part);
}

EntityJointId ZoneContext::joint_named(EntityId root, std::string_view name) const {
    const auto number_in = [&](const auto& joints, const auto& plan_of) -> std::ptrdiff_t {
        const auto at = std::find_if(joints.begin(), joints.end(), [&](const auto& joint) {
            return plan_of(joint).name == name;
        });
        return at != joints.end() ? at - joints.begin() : -1;
    };
    std::ptrdiff_t number = -1;
    if (const AssemblyDef* assembly = root ? assembly_of(*state_, root) : nullptr) {
        number = number_in(assembly->joints,
                           [](const AssemblyJoint& j) -> const JointPlan& { return *j.plan; });
    } else if (!root && state_->settings.placed_joints) {
        number = number_in(*state_->settings.placed_joints,
                           [](const auto& plan) -> const JointPlan& { return *plan; });
    }
    return number < 0 ? EntityJointId()
                      : joint_numbered(*state_, {root, static_cast<std::uint16_t>(number)});
}

EntityJointId ZoneContext::add_joint(EntityId a, EntityId b, const JointPlan& plan) {
    const world::Row row_a = owned(a);
    const world::Row row_b = owned(b);
    if (row_b == world::kNoRow || (a && row_a == world::kNoRow) ||
        state_->assemblies.joints.size() >= kMostJoints) {
        return {};
    }
    const auto made = join(*state_,
                           a,
                           b,
                           std::make_shared<const JointPlan>(plan),
                           present_frame(state_->entities, row_a, row_b),
                           {EntityId(), kUnlisted});
    return made ? *made : EntityJointId();
}

void ZoneContext::remove_joint(EntityJointId joint) {
    if (find_joint(*state_, joint) != nullptr) {
        end_joint(*state_, joint);
    }
}

std::optional<JointReading> ZoneContext::joint(EntityJointId joint) const {
    const EntityJoint* found = find_joint(*state_, joint);
    // One that broke is told of after the rules' tick.
    if (found == nullptr || !state_->scene.contains(found->joint)) {
        return std::nullopt;
    }
    return JointReading{found->a,
                        found->b,
                        state_->scene.joint_position(found->joint),
                        state_->scene.joint_force(found->joint),
                        found->motor,
                        found->target};
}

bool ZoneContext::has_joints(EntityId entity) const {
    return zone::has_joints(*state_, entity);
}

bool ZoneContext::set_motor_target(EntityJointId joint, float target) {
    EntityJoint* found = find_joint(*state_, joint);
    return found != nullptr && zone::set_motor_target(*state_, *found, target);
}

BodyId ZoneContext::prop_body(EntityId entity) const {
    const world::Row row = owned(entity);
    return row != world::kNoRow && is_prop(*state_, row) ? state_->entities.body[row] : BodyId();
}

void ZoneContext::apply_force(EntityId entity, const Vec3& force, const Vec3& point) {
    const BodyId body = prop_body(entity);
    if (body && force.allFinite() && point.allFinite()) {
        state_->scene.apply_force(body, force, point);
    }
}

void ZoneContext::apply_torque(EntityId entity, const Vec3& torque) {
    const BodyId body = prop_body(entity);
    if (body && torque.allFinite()) {
        state_->scene.apply_torque(body, torque);
    }
}

void ZoneContext::apply_impulse(EntityId entity, const Vec3& impulse, const Vec3& point) {
    const BodyId body = prop_body(entity);
    if (!body || !impulse.allFinite() || !point.allFinite()) {
        return;
    }
    state_->scene.apply_impulse(body, impulse, point);
    world::Entities& e = state_->entities;
    const world::Row row = e.find(entity);
    const physics::BodyState pushed = state_->scene.state(body);
    e.set(row, world::kAtRest, false);
    e.velocity[row] = pushed.velocity;
    e.angular_velocity[row] = pushed.angular_velocity;
}

bool ZoneContext::mount(EntityId rider, EntityId root, std::size_t seat) {
    const AssemblyDef* assembly = assembly_of(*state_, root);
    if (assembly == nullptr || seat >= assembly->seats.size()) {
        return false;
    }
    const AssemblySeat& on = assembly->seats[seat];
    const EntityId carrier = part_id(*state_, root, on.part);
    const auto& riders = state_->assemblies.riders;
    const bool taken = std::any_of(riders.begin(), riders.end(), [&](const Rider& other) {
        return other.carrier == carrier && other.place == on.place;
    });
    return !taken && zone::mount(*state_, rider, carrier, on.place, seat == 0 ? root : EntityId());
}

void ZoneContext::dismount(EntityId rider, const Vec3& position) {
    if (ride_of(*state_, rider) != nullptr) {
        teleport(rider, position);
    }
}

EntityId ZoneContext::carrier_of(EntityId rider) const {
    const Rider* ride = ride_of(*state_, rider);
    return ride != nullptr ? ride->carrier : EntityId();
}

std::size_t ZoneContext::seats_of(EntityId root) const {
    const AssemblyDef* assembly = assembly_of(*state_, root);
    return assembly != nullptr ? assembly->seats.size() : 0;
}

}  // namespace zoned::zone
