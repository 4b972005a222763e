#include "server/zone/context/levers.h"

#include "server/zone/zone_state.h"

#include <algorithm>
#include <variant>
#include <vector>

namespace zoned::zone {

namespace {

/// The longest reach of levers that answer to one of the buttons, m; 0: there are none.
float reach_of(const world::TypeTable& types, std::uint16_t pressed) {
    float reach = 0.0F;
    for (const world::EntityType& type : types) {
        if (type.lever && (type.lever->button & pressed) != 0) {
            reach = std::max(reach, type.lever->reach_m);
        }
    }
    return reach;
}

}  // namespace

void use_lever(ZoneState& state, RulesContext& context, EntityId avatar, std::uint16_t pressed) {
    const world::TypeTable& types = *state.settings.types;
    const float reach = pressed != 0 ? reach_of(types, pressed) : 0.0F;
    const world::Entities& e = state.entities;
    const world::Row user = e.find(avatar);
    if (reach == 0.0F || user == world::kNoRow || e.has(user, world::kHidden)) {
        return;
    }
    const Vec3 at = e.position[user];
    std::vector<EntityId> found;
    context.near(at, reach, found);
    EntityId nearest;
    float nearest_m = reach;
    for (const EntityId entity : found) {
        const world::Row row = e.find(entity);
        const std::optional<world::Lever>& lever = types[e.type[row]].lever;
        const float distance = (e.position[row] - at).norm();
        if (lever && (lever->button & pressed) != 0 && distance <= lever->reach_m &&
            (!nearest || distance < nearest_m)) {
            nearest = entity;
            nearest_m = distance;
        }
    }
    const world::Row row = e.find(nearest);
    if (row == world::kNoRow) {
        return;
    }
    if (e.has(row, world::kGhost)) {
        state.out.rules_messages.push_back({nearest, {}, std::nullopt, avatar});
    } else {
        turn_lever(state, context, nearest, avatar);
    }
}

void turn_lever(ZoneState& state, RulesContext& context, EntityId lever, EntityId user) {
    const world::Row row = state.entities.find(lever);
    if (row == world::kNoRow || state.entities.has(row, world::kGhost) ||
        state.entities.has(row, world::kHidden)) {
        return;
    }
    const std::optional<world::Lever>& as = (*state.settings.types)[state.entities.type[row]].lever;
    const std::optional<wire::FieldValue> was = context.field(lever, as->field);
    const bool on = !std::get<bool>(*was);
    context.set_field(lever, as->field, on);
    state.rules->on_use(context, {lever, user, on});
}

}  // namespace zoned::zone
