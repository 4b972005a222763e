#include "server/zone/assemblies/assembly_spawning.h"

#include "server/zone/assemblies/entity_joints.h"
#include "server/zone/assemblies/riding.h"
#include "server/zone/simulation/spawning.h"
#include "shared/core/assert.h"

namespace zoned::zone {

namespace {

physics::Frame pose_of(const AssemblyPart& part) {
    return {part.position, part.orientation};
}

/// The pose of `a` in the axes of `b`.
physics::Frame relative(const physics::Frame& a, const physics::Frame& b) {
    const Quat back = b.rotation.conjugate();
    return {back * (a.position - b.position), back * a.rotation};
}

void spawn_part(ZoneState& state, EntityId root, const AssemblyPart& part) {
    world::Entities& e = state.entities;
    const EntityId id = next_entity_id(state);
    const world::Row row = e.add(id, part.type);
    const world::Row from = e.find(root);
    const Vec3 arm = e.orientation[from] * part.position;
    e.position[row] = e.position[from] + arm;
    e.orientation[row] = (e.orientation[from] * part.orientation).normalized();
    e.velocity[row] = e.velocity[from] + e.angular_velocity[from].cross(arm);
    e.angular_velocity[row] = e.angular_velocity[from];
    e.appearance[row] = e.appearance[from];
    e.discontinuity_tick[row] = state.now;
    add_body(state, row, false);
}

/// The parts of a root that has just been spawned, and the joints between them. They move as one
/// rigid body with the root.
void spawn_parts(ZoneState& state, EntityId root) {
    const AssemblyDef& assembly = *assembly_of(state, root);
    for (std::size_t p = 1; p < assembly.parts.size(); ++p) {
        spawn_part(state, root, assembly.parts[p]);
    }
    const world::Entities& e = state.entities;
    for (std::size_t j = 0; j < assembly.joints.size(); ++j) {
        const AssemblyJoint& joint = assembly.joints[j];
        const bool to_world = joint.a == kWorldPart;
        const EntityId b = part_id(state, root, joint.b);
        const physics::Frame made_at =
            to_world ? present_frame(e, world::kNoRow, e.find(b))
                     : relative(pose_of(assembly.parts[joint.a]), pose_of(assembly.parts[joint.b]));
        const auto made = join(state,
                               to_world ? EntityId() : part_id(state, root, joint.a),
                               b,
                               joint.plan,
                               made_at,
                               {root, static_cast<std::uint16_t>(j)});
        ZONED_ASSERT(made.ok(), "joints of types were checked when the config was read");
    }
}

}  // namespace

EntityId part_id(const ZoneState& state, EntityId root, std::uint16_t part) {
    const auto zones = static_cast<std::uint32_t>(state.settings.regions.size());
    return EntityId(root.value + zones * part);
}

const AssemblyDef* assembly_of(const ZoneState& state, EntityId root) {
    const world::Row row = state.entities.find(root);
    if (row == world::kNoRow) {
        return nullptr;
    }
    const world::EntityType& type = (*state.settings.types)[state.entities.type[row]];
    return type.is_root() ? &(*state.settings.assemblies)[type.assembly - 1U] : nullptr;
}

EntityId root_of(const ZoneState& state, EntityId part) {
    const world::Row row = state.entities.find(part);
    if (row == world::kNoRow) {
        return part;
    }
    const world::EntityType& type = (*state.settings.types)[state.entities.type[row]];
    if (type.assembly == 0 || type.part == 0) {
        return part;
    }
    const auto zones = static_cast<std::uint32_t>(state.settings.regions.size());
    const EntityId root(part.value - zones * type.part);
    const AssemblyDef* assembly = assembly_of(state, root);
    return assembly == &(*state.settings.assemblies)[type.assembly - 1U] ? root : part;
}

EntityId spawn_entity(ZoneState& state, const SpawnDef& def) {
    const EntityId id = next_entity_id(state);
    world::Entities& e = state.entities;
    const world::Row row = e.add(id, def.type);
    const bool character = (*state.settings.types)[def.type].kind == world::EntityKind::kCharacter;
    e.position[row] = def.position;
    e.orientation[row] = character ? motion::orientation_from_yaw(def.yaw) : def.orientation;
    e.velocity[row] = def.velocity;
    e.angular_velocity[row] = def.angular_velocity;
    e.yaw[row] = def.yaw;
    e.command[row].yaw = def.yaw;
    e.appearance[row] = def.appearance;
    e.set_client(row, def.client);
    e.discontinuity_tick[row] = state.now;
    e.set(row, world::kAtRest, def.asleep && !character);
    add_body(state, row, def.asleep);
    add_agent(state, row);
    state.grid_valid = false;
    if ((*state.settings.types)[def.type].is_root()) {
        spawn_parts(state, id);
    }
    return id;
}

void despawn_entity(ZoneState& state, world::Row row) {
    end_rides_of(state, state.entities.id[row]);
    end_joints_of(state, state.entities.id[row]);
    remove_body(state, row);
    if (state.agents.find(state.entities.id[row]) != nullptr) {
        state.paths.release(state.agents.slot_of(state.entities.id[row]));
        state.agents.take(state.entities.id[row]);
    }
    state.entities.remove(row);
    state.grid_valid = false;
}

}  // namespace zoned::zone
