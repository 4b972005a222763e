// Mind fields: all that a mind is, field by field, for whoever hashes, writes or reads minds.
#pragma once

#include "server/ai/mind.h"

#include <array>
#include <cstddef>
#include <type_traits>
#include <utility>

namespace zoned::ai {

/// Calls visit(array[0]), visit(array[1]) and so on. Inlined, with its callers, so that where each
/// number goes is known when this is compiled.
template <class Array, class Visit, std::size_t... kIndex>
[[gnu::always_inline]] inline void visit_each(Array& array,
                                              Visit& visit,
                                              std::index_sequence<kIndex...> /*indices*/) {
    (visit(array[kIndex]), ...);
}

template <class Array, class Visit>
[[gnu::always_inline]] inline void visit_array(Array& array, Visit& visit) {
    constexpr std::size_t kSize = std::tuple_size_v<std::remove_const_t<Array>>;
    visit_each(array, visit, std::make_index_sequence<kSize>());
}

template <class Vector, class Visit>
[[gnu::always_inline]] inline void visit_vector(Vector& vector, Visit& visit) {
    visit_each(vector,
               visit,
               std::make_index_sequence<static_cast<std::size_t>(Vector::SizeAtCompileTime)>());
}

/// Calls `visit(number)` for each number of a mind, in one order; `mind` may be const.
template <class MindOf, class Visit>
[[gnu::always_inline]] inline void visit_fields(MindOf& mind, Visit&& visit) {
    const auto column = [&visit](auto& array) __attribute__((always_inline)) {
        visit(array[0]);
    };
    visit(mind.entity.value);
    visit(mind.machine);
    visit(mind.fsm.leaf[0]);
    visit(mind.fsm.pending[0]);
    visit(mind.fsm.pending_since[0]);
    visit_array(mind.fsm.since, column);
    visit_array(mind.fsm.memory, column);
    visit(mind.doing);
    visit(mind.facts);
    visit_array(mind.variables, visit);
    visit_array(mind.degrees, visit);
    visit(mind.variables_at);
    visit(mind.next_decision);
    visit_vector(mind.home, visit);
    visit_vector(mind.target, visit);
    visit(mind.corner);
    visit(mind.steps);
    visit(mind.prey.value);
    visit(mind.ward.value);
    visit(mind.noticed);
    visit_vector(mind.known, visit);
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
    visit_vector(mind.anchor, visit);
    visit(mind.anchor_since);
    visit(mind.detour_until);
    visit(mind.band);
    visit(mind.tier);
    visit(mind.unseen_since);
    visit(mind.timed);
    visit_vector(mind.segment.from, visit);
    visit_vector(mind.segment.direction, visit);
    visit(mind.segment.speed);
    visit(mind.segment.length);
    visit_vector(mind.segment.bend, visit);
    visit(mind.segment.bend_s);
    visit(mind.segment.since);
    visit_vector(mind.segment.goal, visit);
    visit(mind.track.lane);
    visit(mind.track.from);
    visit(mind.track.s);
    visit(mind.track.from_s);
    visit(mind.track.changed);
    visit(mind.track.to_change);
    visit(mind.track.due);
    visit(mind.track.due_s);
    visit(mind.on_path);
    visit(mind.again_at);
    visit_vector(mind.placed, visit);
    visit(mind.next_event);
    visit(mind.look_at);
    visit(mind.wait.clauses);
    visit(mind.wait.held);
    visit(mind.wait.trades);
}

/// Of these those that become other where a segment ends and nothing is decided, large and small
/// ones so that they fill words (core::BlockHash::pack()).
template <class MindOf, class Visit>
[[gnu::always_inline]] inline void visit_walk_fields(MindOf& mind, Visit&& visit) {
    visit(mind.rng.state);
    visit_vector(mind.target, visit);
    visit(mind.corner);
    visit(mind.aim.buttons);
    visit(mind.steps);
    visit(mind.aim.move_x);
    visit(mind.aim.move_z);
    visit(mind.aim.yaw);
    visit(mind.timed);
    visit(mind.on_path);
    visit(mind.entered);
    visit(mind.fresh);
    visit_vector(mind.anchor, visit);
    visit(mind.segment.bend_s);
    visit(mind.anchor_since);
    visit_vector(mind.segment.from, visit);
    visit_vector(mind.segment.direction, visit);
    visit(mind.segment.speed);
    visit(mind.segment.length);
    visit_vector(mind.segment.bend, visit);
    visit(mind.segment.since);
    visit_vector(mind.segment.goal, visit);
    visit(mind.track.lane);
    visit(mind.track.from);
    visit(mind.track.s);
    visit(mind.track.from_s);
    visit(mind.track.changed);
    visit(mind.track.to_change);
    visit(mind.track.due);
    visit(mind.track.due_s);
    visit(mind.again_at);
    visit_vector(mind.placed, visit);
    visit(mind.next_decision);
    visit(mind.next_event);
    visit(mind.look_at);
}

}  // namespace zoned::ai
