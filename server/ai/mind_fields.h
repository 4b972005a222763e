// Mind fields: all that a mind is, field by field, for whoever hashes, writes or reads minds.
#pragma once

#include "server/ai/mind.h"

#include <type_traits>

namespace zoned::ai {

/// Calls `visit(number)` for each number of a mind, in one order; `mind` may be const.
template <class MindOf, class Visit>
void visit_fields(MindOf& mind, Visit&& visit) {
    const auto vector = [&visit](auto& v) {
        for (Eigen::Index i = 0; i < v.size(); ++i) {
            visit(v[i]);
        }
    };
    const auto columns = [&visit](auto& arrays) {
        for (auto& array : arrays) {
            visit(array[0]);
        }
    };
    visit(mind.entity.value);
    visit(mind.machine);
    visit(mind.fsm.leaf[0]);
    visit(mind.fsm.pending[0]);
    visit(mind.fsm.pending_since[0]);
    columns(mind.fsm.since);
    columns(mind.fsm.memory);
    visit(mind.doing);
    visit(mind.facts);
    for (auto& variable : mind.variables) {
        visit(variable);
    }
    for (auto& degree : mind.degrees) {
        visit(degree);
    }
    visit(mind.variables_at);
    visit(mind.next_decision);
    vector(mind.home);
    vector(mind.target);
    visit(mind.corner);
    visit(mind.steps);
    visit(mind.prey.value);
    visit(mind.ward.value);
    visit(mind.noticed);
    vector(mind.known);
    visit(mind.known_at);
    visit(mind.rng.state);
    visit(mind.rng.stream);
    visit(mind.wants);
    visit(mind.entered);
    visit(mind.fresh);
    visit(mind.far);
    visit(mind.next_steering);
    visit(mind.aim.move_x);
    visit(mind.aim.move_z);
    visit(mind.aim.yaw);
    visit(mind.aim.buttons);
    vector(mind.anchor);
    visit(mind.anchor_since);
    visit(mind.detour_until);
    visit(mind.band);
    visit(mind.tier);
    visit(mind.unseen_since);
    visit(mind.timed);
    vector(mind.leg.from);
    vector(mind.leg.direction);
    visit(mind.leg.speed);
    visit(mind.leg.length);
    vector(mind.leg.bend);
    visit(mind.leg.bend_s);
    visit(mind.leg.since);
    vector(mind.leg.goal);
    visit(mind.track.lane);
    visit(mind.track.from);
    visit(mind.track.s);
    visit(mind.track.from_s);
    visit(mind.track.changed);
    visit(mind.track.to_change);
    visit(mind.track.due);
    visit(mind.track.due_s);
    visit(mind.on_way);
    visit(mind.again_at);
    vector(mind.placed);
    visit(mind.next_event);
    visit(mind.look_at);
    visit(mind.wait.clauses);
    visit(mind.wait.held);
    visit(mind.wait.trades);
}

}  // namespace zoned::ai
