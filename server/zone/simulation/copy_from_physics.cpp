#include "server/zone/simulation/copy_from_physics.h"

#include "server/zone/simulation/approaching_props.h"
#include "server/zone/simulation/soft_hull.h"

#include <algorithm>

namespace zoned::zone {

namespace {

ZoneId ghost_owner(const ZoneState& state, EntityId ghost) {
    const auto it = std::lower_bound(state.ghost_ids.begin(), state.ghost_ids.end(), ghost);
    if (it == state.ghost_ids.end() || *it != ghost) {
        return {};
    }
    return state.ghost_owners[static_cast<std::size_t>(it - state.ghost_ids.begin())];
}

/// Two props that touch across a border belong into one zone.
void note_ghost_contact(ZoneState& state, EntityId a, EntityId b) {
    const world::Row row_a = state.entities.find(a);
    const world::Row row_b = state.entities.find(b);
    if (row_a == world::kNoRow || row_b == world::kNoRow || !is_prop(state, row_a) ||
        !is_prop(state, row_b)) {
        return;
    }
    const bool ghost_a = state.entities.has(row_a, world::kGhost);
    const bool ghost_b = state.entities.has(row_b, world::kGhost);
    if (ghost_a != ghost_b) {
        state.ghost_contacts.push_back({ghost_a ? b : a, ghost_owner(state, ghost_a ? a : b)});
    }
}

}  // namespace

std::uint32_t copy_moved_bodies(ZoneState& state) {
    world::Entities& e = state.entities;
    std::uint32_t copied = 0;
    for (const BodyId body : state.scene.moved()) {
        const world::Row row = e.find(EntityId(state.scene.user(body)));
        if (row == world::kNoRow || e.has(row, world::kGhost) || !is_prop(state, row)) {
            continue;
        }
        const physics::BodyState moved = state.scene.state(body);
        e.acceleration[row] = (moved.velocity - e.velocity[row]) / state.settings.dt;
        e.position[row] = moved.position;
        e.orientation[row] = turn_of_hull(state, row, moved.orientation);
        e.velocity[row] = moved.asleep ? Vec3(Vec3::Zero()) : moved.velocity;
        e.angular_velocity[row] = moved.asleep ? Vec3(Vec3::Zero()) : moved.angular_velocity;
        if (moved.asleep) {
            e.acceleration[row].setZero();
        }
        if (moved.asleep && e.has(row, world::kAtRest)) {
            e.touch_passing(row);
        }
        e.set(row, world::kAtRest, moved.asleep);
        ++copied;
    }
    state.grid_valid = state.grid_valid && copied == 0;
    return copied;
}

std::uint32_t report_contacts(ZoneState& state, RulesContext& context) {
    // Rules may add and remove bodies, so they get copies of the lists of physics.
    const auto events = state.scene.contact_events();
    state.contacts.clear();
    for (const physics::ContactEvent& event : events) {
        EntityContact contact;
        contact.a = EntityId(event.user_a);
        contact.b = EntityId(event.user_b);
        contact.point = event.point;
        contact.normal = event.normal;
        contact.impulse = event.impulse;
        contact.approach_speed = event.approach_speed;
        contact.began = event.began;
        contact.ended = event.ended;
        state.contacts.push_back(contact);
        // The zone of an island must not depend on the contacts that the rules ask for.
        const bool strong = event.impulse >= state.settings.physics.event_impulse_ns;
        if (contact.a && contact.b && (event.began || strong)) {
            note_ghost_contact(state, contact.a, contact.b);
        }
    }
    for (const EntityContact& contact : state.contacts) {
        state.rules->on_contact(context, contact);
    }
    return static_cast<std::uint32_t>(state.contacts.size());
}

}  // namespace zoned::zone
