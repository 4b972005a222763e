#include "server/zone/assemblies/entity_joints.h"

#include "server/zone/assemblies/assembly_spawning.h"
#include "server/zone/assemblies/motors.h"
#include "server/zone/simulation/approaching_props.h"
#include "shared/core/assert.h"

#include <algorithm>
#include <unordered_set>
#include <utility>

namespace zoned::zone {

namespace {

template <class Joints>
auto joint_at(Joints& joints, EntityJointId id) {
    return std::lower_bound(
        joints.begin(), joints.end(), id, [](const EntityJoint& joint, EntityJointId wanted) {
            return joint.id < wanted;
        });
}

void insert_end(ZoneState& state, EntityId entity, EntityJointId joint) {
    if (entity) {
        auto& ends = state.assemblies.joints_of;
        const std::pair<EntityId, EntityJointId> end(entity, joint);
        ends.insert(std::lower_bound(ends.begin(), ends.end(), end), end);
    }
}

void erase_end(ZoneState& state, EntityId entity, EntityJointId joint) {
    auto& ends = state.assemblies.joints_of;
    const std::pair<EntityId, EntityJointId> end(entity, joint);
    const auto at = std::lower_bound(ends.begin(), ends.end(), end);
    if (at != ends.end() && *at == end) {
        ends.erase(at);
    }
}

/// Calls visit(joint) for each joint of an entity; the visitor must not change the list.
template <class Visit>
void for_each_joint_of(const ZoneState& state, EntityId entity, Visit&& visit) {
    const auto& ends = state.assemblies.joints_of;
    for (auto at = std::lower_bound(
             ends.begin(), ends.end(), std::pair<EntityId, EntityJointId>(entity, {}));
         at != ends.end() && at->first == entity;
         ++at) {
        visit(at->second);
    }
}

/// The definition with its points where the joint was made.
physics::JointDef placed_def(const JointPlan& plan,
                             const physics::Frame& frame_a,
                             const physics::Frame& frame_b,
                             bool to_world) {
    const auto on = [](const physics::Frame& frame, const Vec3& point) {
        return Vec3(frame.position + frame.rotation * point);
    };
    physics::JointDef def = plan.def;
    const bool two_points =
        def.kind == physics::JointKind::kDistance || def.kind == physics::JointKind::kSpring;
    def.anchor = on(two_points && !to_world ? frame_a : frame_b, plan.def.anchor);
    def.anchor_b = on(frame_b, plan.def.anchor_b);
    def.axis = frame_b.rotation * plan.def.axis;
    def.cone_axis = frame_b.rotation * plan.def.cone_axis;
    return def;
}

BodyId body_of_entity(const ZoneState& state, EntityId entity) {
    const world::Row row = state.entities.find(entity);
    return row == world::kNoRow || state.entities.has(row, world::kGhost)
               ? BodyId()
               : state.entities.body[row];
}

/// Puts the joint into the scene.
core::Result<JointId> realize(ZoneState& state, const EntityJoint& joint) {
    const bool to_world = !joint.a;
    const physics::Frame frame_a = to_world ? physics::Frame() : joint.made_at;
    const physics::Frame frame_b = to_world ? joint.made_at : physics::Frame();
    physics::JointDef def = placed_def(*joint.plan, frame_a, frame_b, to_world);
    def.a = body_of_entity(state, joint.a);
    def.b = body_of_entity(state, joint.b);
    def.user = joint.id.value;
    if (!def.b || (!to_world && !def.a)) {
        return core::Result<JointId>::failure("an end is no rigid body of this zone");
    }
    return state.scene.add_joint(def, frame_a, frame_b);
}

void list(ZoneState& state, EntityJoint joint) {
    AssemblyState& all = state.assemblies;
    all.changed.push_back(joint.id);
    insert_end(state, joint.a, joint.id);
    insert_end(state, joint.b, joint.id);
    if (joint.motor) {
        all.motors.insert(std::lower_bound(all.motors.begin(), all.motors.end(), joint.id),
                          joint.id);
    }
    all.joints.insert(joint_at(all.joints, joint.id), std::move(joint));
}

EntityJoint unlist(ZoneState& state, EntityJointId id) {
    AssemblyState& all = state.assemblies;
    const auto at = joint_at(all.joints, id);
    ZONED_ASSERT(at != all.joints.end() && at->id == id, "a joint that is listed");
    EntityJoint joint = std::move(*at);
    all.joints.erase(at);
    erase_end(state, joint.a, id);
    erase_end(state, joint.b, id);
    if (joint.motor) {
        all.motors.erase(std::lower_bound(all.motors.begin(), all.motors.end(), id));
    }
    all.changed.push_back(id);
    return joint;
}

bool holds_agent(const ZoneState& state, EntityId entity) {
    return entity && state.agents.find(entity) != nullptr;
}

/// Rows to which joints or riding lead from one.
void add_neighbours(const ZoneState& state,
                    world::Row row,
                    std::unordered_set<world::Row>& seen,
                    std::vector<world::Row>& rows) {
    const world::Entities& e = state.entities;
    const auto add = [&](EntityId entity) {
        const world::Row other = entity ? e.find(entity) : world::kNoRow;
        if (other != world::kNoRow && !e.has(other, world::kGhost) && seen.insert(other).second) {
            rows.push_back(other);
        }
    };
    for_each_joint_of(state, e.id[row], [&](EntityJointId id) {
        const EntityJoint& joint = *find_joint(state, id);
        add(joint.a);
        add(joint.b);
    });
    for (const Rider& rider : state.assemblies.riders) {
        if (rider.rider == e.id[row]) {
            add(rider.carrier);
        } else if (rider.carrier == e.id[row]) {
            add(rider.rider);
        }
    }
}

void add_touching(const ZoneState& state,
                  world::Row row,
                  std::unordered_set<world::Row>& seen,
                  std::vector<world::Row>& rows) {
    const world::Entities& e = state.entities;
    if (!is_prop(state, row) || !e.body[row]) {
        return;
    }
    std::vector<BodyId> bodies;
    state.scene.island_of(e.body[row], bodies);
    for (const BodyId body : bodies) {
        const world::Row other = e.find(EntityId(state.scene.user(body)));
        if (other != world::kNoRow && is_prop(state, other) && !e.has(other, world::kGhost) &&
            seen.insert(other).second) {
            rows.push_back(other);
        }
    }
}

void grow(const ZoneState& state, std::vector<world::Row>& rows, bool touching) {
    if (state.assemblies.joints.empty() && state.assemblies.riders.empty()) {
        return;
    }
    std::unordered_set<world::Row> seen(rows.begin(), rows.end());
    const std::size_t given = rows.size();
    for (std::size_t i = 0; i < rows.size(); ++i) {
        add_neighbours(state, rows[i], seen, rows);
        if (touching && i >= given) {
            add_touching(state, rows[i], seen, rows);
        }
    }
}

}  // namespace

core::Result<EntityJointId> join(ZoneState& state,
                                 EntityId a,
                                 EntityId b,
                                 const std::shared_ptr<const JointPlan>& plan,
                                 const physics::Frame& made_at,
                                 const JointOrigin& origin) {
    using Refused = core::Result<EntityJointId>;
    if (holds_agent(state, a) || holds_agent(state, b)) {
        return Refused::failure("joint: an entity with an agent takes no joint");
    }
    EntityJoint joint;
    joint.a = a;
    joint.b = b;
    joint.root = origin.root;
    joint.number = origin.number;
    joint.plan = plan;
    joint.made_at = made_at;
    const auto zones = static_cast<std::uint32_t>(state.settings.regions.size());
    joint.id = EntityJointId(state.settings.id.value + zones * state.assemblies.next_joint);
    const auto made = realize(state, joint);
    if (!made) {
        return Refused::failure(made.error());
    }
    ++state.assemblies.next_joint;
    joint.joint = *made;
    begin_motor(state, joint);
    const EntityJointId id = joint.id;
    list(state, std::move(joint));
    return id;
}

physics::Frame present_frame(const world::Entities& entities, world::Row a, world::Row b) {
    const physics::Frame of_b{entities.position[b], entities.orientation[b]};
    if (a == world::kNoRow) {
        return of_b;
    }
    const Quat back = of_b.rotation.conjugate();
    return {back * (entities.position[a] - of_b.position), back * entities.orientation[a]};
}

EntityJoint* find_joint(ZoneState& state, EntityJointId joint) {
    const auto at = joint_at(state.assemblies.joints, joint);
    return at != state.assemblies.joints.end() && at->id == joint ? &*at : nullptr;
}

const EntityJoint* find_joint(const ZoneState& state, EntityJointId joint) {
    const auto at = joint_at(state.assemblies.joints, joint);
    return at != state.assemblies.joints.end() && at->id == joint ? &*at : nullptr;
}

EntityJointId joint_numbered(const ZoneState& state, const JointOrigin& origin) {
    if (!origin.root) {
        const auto& joints = state.assemblies.joints;
        const auto at = std::find_if(joints.begin(), joints.end(), [&](const EntityJoint& joint) {
            return !joint.root && joint.number == origin.number;
        });
        return at != joints.end() ? at->id : EntityJointId();
    }
    EntityJointId found;
    const AssemblyDef* assembly = assembly_of(state, origin.root);
    if (assembly != nullptr && origin.number < assembly->joints.size()) {
        const EntityId b = part_id(state, origin.root, assembly->joints[origin.number].b);
        for_each_joint_of(state, b, [&](EntityJointId id) {
            const EntityJoint& joint = *find_joint(state, id);
            if (joint.root == origin.root && joint.number == origin.number) {
                found = id;
            }
        });
    }
    return found;
}

void end_joint(ZoneState& state, EntityJointId joint) {
    const EntityJoint ended = unlist(state, joint);
    if (state.scene.contains(ended.joint)) {
        state.scene.remove_joint(ended.joint);
    }
}

void end_joints_of(ZoneState& state, EntityId entity) {
    std::vector<EntityJointId> ends;
    for_each_joint_of(state, entity, [&](EntityJointId id) { ends.push_back(id); });
    for (const EntityJointId id : ends) {
        end_joint(state, id);
    }
}

bool has_joints(const ZoneState& state, EntityId entity) {
    bool any = false;
    for_each_joint_of(state, entity, [&](EntityJointId) { any = true; });
    return any;
}

std::uint32_t report_breaks(ZoneState& state, RulesContext& context) {
    std::vector<BrokenJoint> broken;
    for (const physics::JointBreak& event : state.scene.joint_breaks()) {
        const EntityJointId id(event.user);
        if (find_joint(state, id) != nullptr) {
            const EntityJoint joint = unlist(state, id);
            broken.push_back({id, joint.a, joint.b, joint.root, joint.plan->name, event.force_n});
        }
    }
    for (const BrokenJoint& joint : broken) {
        state.rules->on_joint_broken(context, joint);
    }
    return static_cast<std::uint32_t>(broken.size());
}

void add_held(const ZoneState& state, std::vector<world::Row>& rows) {
    grow(state, rows, false);
}

void add_held_and_touching(const ZoneState& state, std::vector<world::Row>& rows) {
    grow(state, rows, true);
}

std::vector<JointTransfer> take_joints(ZoneState& state, const std::vector<EntityId>& entities) {
    const auto leaves = [&](EntityId entity) {
        return std::binary_search(entities.begin(), entities.end(), entity);
    };
    std::vector<JointTransfer> taken;
    std::vector<EntityJointId> ids;
    for (const EntityId entity : entities) {
        for_each_joint_of(state, entity, [&](EntityJointId id) {
            if (find_joint(state, id)->b == entity) {
                ids.push_back(id);
            }
        });
    }
    for (const EntityJointId id : ids) {
        const EntityJoint& joint = *find_joint(state, id);
        ZONED_ASSERT(!joint.a || leaves(joint.a), "what joints hold together leaves together");
        const physics::JointState carried = state.scene.joint_state(joint.joint);
        state.scene.remove_joint(joint.joint);
        taken.push_back({unlist(state, id), carried});
    }
    return taken;
}

void give_joint(ZoneState& state, JointTransfer from, const Vec3& shift) {
    EntityJoint& joint = from.joint;
    if (!joint.a) {
        joint.made_at.position += shift;
    }
    const auto made = realize(state, joint);
    ZONED_ASSERT(made.ok(), "a joint of one zone is one of another");
    joint.joint = *made;
    if (joint.motor) {
        state.scene.set_motor(joint.joint, joint.speed, joint.most);
    }
    state.scene.set_joint_state(joint.joint, from.state);
    list(state, std::move(joint));
}

void hash_assemblies(ZoneState& state, core::StateHash& hash) {
    AssemblyState& all = state.assemblies;
    if (!all.changed.empty()) {
        std::sort(all.changed.begin(), all.changed.end());
        all.changed.erase(std::unique(all.changed.begin(), all.changed.end()), all.changed.end());
        for (const EntityJointId id : all.changed) {
            hash.add(id.value);
            const EntityJoint* joint = find_joint(state, id);
            hash.add(joint != nullptr);
            if (joint != nullptr) {
                hash.add(joint->a.value);
                hash.add(joint->b.value);
                hash.add(joint->by_hand);
                hash.add(joint->target);
                hash.add(joint->speed);
                hash.add(joint->most);
            }
        }
        all.changed.clear();
    }
    if (!all.joints.empty()) {
        hash.add(static_cast<std::uint64_t>(all.joints.size()));
    }
    if (state.report.plan.has(Pass::kPhysics)) {
        state.scene.hash_joints(hash);
    }
    for (const Rider& rider : all.riders) {
        hash.add(rider.rider.value);
        hash.add(rider.carrier.value);
    }
}

}  // namespace zoned::zone
