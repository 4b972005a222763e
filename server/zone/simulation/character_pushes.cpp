#include "server/zone/simulation/character_pushes.h"

#include "server/zone/simulation/approaching_props.h"

#include <algorithm>

namespace zoned::zone {

namespace {

/// A character that is simulated here and has an agent.
bool is_pushed(const ZoneState& state, world::Row row) {
    const world::Entities& e = state.entities;
    const world::EntityType& type = (*state.settings.types)[e.type[row]];
    return type.kind == world::EntityKind::kCharacter && type.brain != 0 && !e.client[row] &&
           !e.has(row, world::kGhost) && !e.has(row, world::kHidden);
}

/// `normal` from the body to the character. True when it changed the character's velocity.
bool push(ZoneState& state,
          world::Row body,
          world::Row character,
          const Vec3& normal,
          float impulse) {
    world::Entities& e = state.entities;
    const world::TypeTable& types = *state.settings.types;
    const world::EntityType& pushed = types[e.type[character]];
    const float comes = normal.dot(e.velocity[body]);
    const float meets = -normal.dot(e.velocity[character]);
    if (!(comes > 0.0F)) {
        return false;
    }
    const float share = comes / (comes + std::max(meets, 0.0F));
    const float gained = share * impulse / (pushed.mass + types[e.type[body]].mass);
    const float change = std::min({gained, comes + meets, pushed.max_velocity_jump_mps});
    if (!(change > 0.0F)) {
        return false;
    }
    Vec3 knock = normal * change;
    // Upwards the ground has to be left, which only a strong push does: rules throw people.
    knock.y() = 0.0F;
    e.velocity[character] += knock;
    e.set(character, world::kAtRest, false);
    return true;
}

}  // namespace

std::uint32_t push_characters(ZoneState& state) {
    std::uint32_t pushed = 0;
    for (const physics::ContactEvent& event : state.scene.contact_events()) {
        if (event.ended || !(event.impulse > 0.0F)) {
            continue;
        }
        const world::Row a = state.entities.find(EntityId(event.user_a));
        const world::Row b = state.entities.find(EntityId(event.user_b));
        if (a == world::kNoRow || b == world::kNoRow) {
            continue;
        }
        const bool moved = (is_prop(state, a) && is_pushed(state, b) &&
                            push(state, a, b, event.normal, event.impulse)) ||
                           (is_prop(state, b) && is_pushed(state, a) &&
                            push(state, b, a, Vec3(-event.normal), event.impulse));
        pushed += moved ? 1U : 0U;
    }
    return pushed;
}

}  // namespace zoned::zone
