#include "server/zone/simulation/spawning.h"

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
    state.entities.set_representation(row, 0);
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

}  // namespace zoned::zone
