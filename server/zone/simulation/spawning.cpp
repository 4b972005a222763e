#include "server/zone/simulation/spawning.h"

#include "server/zone/assemblies/assembly_spawning.h"
#include "server/zone/assemblies/entity_joints.h"
#include "server/zone/assemblies/riding.h"
#include "server/zone/simulation/type_body.h"
#include "server/zone/simulation/zone_soft_bodies.h"
#include "shared/core/assert.h"

namespace zoned::zone {

EntityId next_entity_id(ZoneState& state) {
    const auto zones = static_cast<std::uint32_t>(state.settings.regions.size());
    const std::uint32_t id = state.settings.id.value + zones * state.next_entity++;
    return EntityId(id);
}

void add_body(ZoneState& state, world::Row row, bool asleep) {
    world::Entities& e = state.entities;
    if (is_soft(state, row)) {
        // Soft bodies do not meet each other: a rigid ghost of one, that nothing can push, would
        // throw another about.
        if (!e.has(row, world::kGhost)) {
            add_soft(state, row, asleep);
        }
        return;
    }
    const world::EntityType& type = (*state.settings.types)[e.type[row]];
    physics::BodyDef def = body_of(type, state.settings.solids);
    if (e.has(row, world::kGhost)) {
        def.kind = physics::BodyKind::kKinematic;  // its owner moves it
    }
    def.position = e.position[row];
    def.orientation = e.orientation[row];
    def.velocity = e.velocity[row];
    def.angular_velocity = e.angular_velocity[row];
    def.user = e.id[row].value;
    def.asleep = asleep && def.kind == physics::BodyKind::kDynamic;
    const ContactWish wish = state.rules->contact_wish(e.type[row]);
    def.events = static_cast<std::uint8_t>((wish.lasts ? physics::kTellPersist : 0) |
                                           (wish.ends ? physics::kTellEnd : 0));
    const auto body = state.scene.add(def);
    ZONED_ASSERT(body.ok(), "entity types and states are valid bodies");
    e.body[row] = *body;
}

void remove_body(ZoneState& state, world::Row row) {
    state.entities.representation[row] = 0;
    if (state.entities.body[row]) {
        state.scene.remove(state.entities.body[row]);
        state.entities.body[row] = BodyId();
    }
    if (state.soft != nullptr) {
        remove_soft(state, state.entities.id[row]);
    }
}

void add_agent(ZoneState& state, world::Row row) {
    const world::Entities& e = state.entities;
    const world::EntityType& type = (*state.settings.types)[e.type[row]];
    if (type.brain == 0) {
        return;
    }
    ai::Agent agent;
    agent.entity = e.id[row];
    const std::vector<std::uint16_t>& of_type = state.settings.ai.brain_of_type;
    agent.brain =
        static_cast<std::uint16_t>((of_type.empty() ? type.brain : of_type[e.type[row]]) - 1);
    ai::begin(agent, state.settings.ai.compiled[agent.brain], state.now);
    agent.home = e.position[row];
    agent.target = e.position[row];
    agent.rng = core::Rng(state.settings.seed, e.id[row].value);
    state.agents.add(agent);
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
