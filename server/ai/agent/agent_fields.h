// Agent fields: visits every field of an agent, for code that hashes, writes or reads agents.
#pragma once

#include "server/ai/agent/agent.h"

#include <array>
#include <cstddef>
#include <type_traits>
#include <utility>

namespace zoned::ai {

/// Calls visit(array[0]), visit(array[1]) and so on. Inlined, like its callers, so that the place
/// of each number is known at compile time.
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

/// Calls `visit(number)` for each number of an agent, always in the same order. `agent` may be
/// const.
template <class AgentOf, class Visit>
[[gnu::always_inline]] inline void visit_fields(AgentOf& agent, Visit&& visit) {
    visit(agent.entity.value);
    visit(agent.brain);
    visit(agent.state_machine.leaf);
    visit(agent.state_machine.pending);
    visit(agent.state_machine.pending_since);
    visit_array(agent.state_machine.since, visit);
    visit_array(agent.state_machine.memory, visit);
    visit(agent.current_action);
    visit(agent.facts);
    visit_array(agent.variables, visit);
    visit_array(agent.degrees, visit);
    visit(agent.variables_at);
    visit(agent.next_decision);
    visit_vector(agent.home, visit);
    visit_vector(agent.target, visit);
    visit(agent.corner);
    visit(agent.steps);
    visit(agent.prey.value);
    visit(agent.ward.value);
    visit(agent.noticed);
    visit_vector(agent.known, visit);
    visit(agent.known_at);
    visit(agent.rng.state);
    visit(agent.rng.stream);
    visit(agent.wants);
    visit(agent.entered);
    visit(agent.fresh);
    visit(agent.far);
    visit(agent.next_steering);
    visit(agent.aim.move_x);
    visit(agent.aim.move_z);
    visit(agent.aim.yaw);
    visit(agent.aim.buttons);
    visit_vector(agent.anchor, visit);
    visit(agent.anchor_since);
    visit(agent.detour_until);
    visit(agent.band);
    visit(agent.tier);
    visit(agent.offscreen_since);
    visit(agent.timed);
    visit_vector(agent.segment.from, visit);
    visit_vector(agent.segment.direction, visit);
    visit(agent.segment.speed);
    visit(agent.segment.length);
    visit_vector(agent.segment.bend, visit);
    visit(agent.segment.bend_s);
    visit(agent.segment.since);
    visit_vector(agent.segment.goal, visit);
    visit(agent.track.lane);
    visit(agent.track.from);
    visit(agent.track.s);
    visit(agent.track.from_s);
    visit(agent.track.changed);
    visit(agent.track.to_change);
    visit(agent.track.due);
    visit(agent.track.due_s);
    visit(agent.on_path);
    visit(agent.again_at);
    visit_vector(agent.placed, visit);
    visit(agent.next_event);
    visit(agent.next_proximity_check);
    visit(agent.wait.clauses);
    visit(agent.wait.held);
    visit(agent.wait.trades);
}

/// Visits the fields that change at the end of a segment without a decision. Large and small fields
/// are ordered so that they fill words (core::BlockHash::pack()).
template <class AgentOf, class Visit>
[[gnu::always_inline]] inline void visit_walk_fields(AgentOf& agent, Visit&& visit) {
    visit(agent.rng.state);
    visit_vector(agent.target, visit);
    visit(agent.corner);
    visit(agent.aim.buttons);
    visit(agent.steps);
    visit(agent.aim.move_x);
    visit(agent.aim.move_z);
    visit(agent.aim.yaw);
    visit(agent.timed);
    visit(agent.on_path);
    visit(agent.entered);
    visit(agent.fresh);
    visit_vector(agent.anchor, visit);
    visit(agent.segment.bend_s);
    visit(agent.anchor_since);
    visit_vector(agent.segment.from, visit);
    visit_vector(agent.segment.direction, visit);
    visit(agent.segment.speed);
    visit(agent.segment.length);
    visit_vector(agent.segment.bend, visit);
    visit(agent.segment.since);
    visit_vector(agent.segment.goal, visit);
    visit(agent.track.lane);
    visit(agent.track.from);
    visit(agent.track.s);
    visit(agent.track.from_s);
    visit(agent.track.changed);
    visit(agent.track.to_change);
    visit(agent.track.due);
    visit(agent.track.due_s);
    visit(agent.again_at);
    visit_vector(agent.placed, visit);
    visit(agent.next_decision);
    visit(agent.next_event);
    visit(agent.next_proximity_check);
}

}  // namespace zoned::ai
