#include "server/zone/simulation/soft_hull.h"

#include "server/zone/simulation/zone_soft_bodies.h"

namespace zoned::zone {

bool step_down_soft(ZoneState& state, world::Row row) {
    world::Entities& e = state.entities;
    SoftLink* link = soft_link(state, e.id[row]);
    if (link == nullptr || e.body[row]) {
        return false;
    }
    physics::soft::SoftBodies& bodies = state.soft->bodies;
    const auto def = bodies.rigid_body(link->body);
    if (!def) {
        return false;
    }
    const auto body = state.scene.add(*def);
    if (!body) {
        return false;
    }
    bodies.step_down(link->body);
    link->start = def->orientation;
    link->turn = def->orientation.conjugate() * e.orientation[row];
    e.body[row] = *body;
    return true;
}

void step_up_soft(ZoneState& state, world::Row row) {
    world::Entities& e = state.entities;
    const SoftLink* link = soft_link(state, e.id[row]);
    if (link == nullptr || !e.body[row]) {
        return;
    }
    const physics::BodyState now = state.scene.state(e.body[row]);
    state.soft->bodies.step_up(link->body,
                               now.position,
                               (now.orientation * link->start.conjugate()).normalized(),
                               now.velocity,
                               now.angular_velocity);
    state.scene.remove(e.body[row]);
    e.body[row] = BodyId();
    e.set_representation(row, 0);
}

Quat turn_of_hull(const ZoneState& state, world::Row row, const Quat& turn) {
    const SoftLink* link = is_soft(state, row) ? soft_link(state, state.entities.id[row]) : nullptr;
    return link == nullptr ? turn : Quat((turn * link->turn).normalized());
}

}  // namespace zoned::zone
