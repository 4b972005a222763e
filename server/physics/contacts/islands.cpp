#include "server/physics/contacts/islands.h"

#include <algorithm>

namespace zoned::physics {

void Waker::wake(Bodies& bodies, ContactGraph& graph, const JointTable& joints, std::uint32_t row) {
    if (!bodies.is_dynamic(row)) {
        return;
    }
    bodies.still_s[row] = 0.0F;
    if (bodies.awake[row] != 0) {
        return;
    }
    stack_.clear();
    stack_.push_back(row);
    bodies.mark_awake(row);
    while (!stack_.empty()) {
        const std::uint32_t at = stack_.back();
        stack_.pop_back();
        bodies.still_s[at] = 0.0F;
        graph.for_each_of(bodies, at, [&](std::uint32_t contact, std::uint32_t other) {
            graph.activate(contact);
            if (graph.pair(contact).touching && bodies.is_dynamic(other) &&
                bodies.awake[other] == 0) {
                bodies.mark_awake(other);
                stack_.push_back(other);
            }
        });
        joints.for_each_of(bodies, at, [&](std::uint32_t, std::uint32_t other) {
            if (other != kNoIndex && bodies.is_dynamic(other) && bodies.awake[other] == 0) {
                bodies.mark_awake(other);
                stack_.push_back(other);
            }
        });
    }
}

void put_to_sleep(Bodies& bodies, ContactGraph& graph, std::uint32_t row) {
    bodies.velocity[row].setZero();
    bodies.angular_velocity[row].setZero();
    bodies.mark_asleep(row);
    graph.for_each_of(bodies, row, [&](std::uint32_t contact, std::uint32_t other) {
        if (!bodies.simulated(other)) {
            graph.deactivate(contact);
        }
    });
}

std::uint32_t Islands::update(Bodies& bodies,
                              ContactGraph& graph,
                              const JointTable& joints,
                              std::span<const std::uint32_t> active_joints,
                              const Limits& limits) {
    const auto& list = bodies.awake_list;
    sets_.reset(list.size());
    still_s_.assign(list.size(), INFINITY);
    for (std::size_t i = 0; i < list.size(); ++i) {
        const std::uint32_t row = list[i];
        bodies.solver_slot[row] = static_cast<std::uint32_t>(i);
        const bool still = bodies.velocity[row].squaredNorm() < limits.speed * limits.speed &&
                           bodies.angular_velocity[row].squaredNorm() < limits.spin * limits.spin;
        bodies.still_s[row] = still ? bodies.still_s[row] + limits.dt : 0.0F;
    }
    for (const std::uint32_t index : graph.active()) {
        const Pair& contact = graph.pair(index);
        if (!contact.touching) {
            continue;
        }
        const bool a = bodies.simulated(contact.a);
        const bool b = bodies.simulated(contact.b);
        if (a && b) {
            sets_.join(bodies.solver_slot[contact.a], bodies.solver_slot[contact.b]);
        } else if (bodies.awake[a ? contact.b : contact.a] != 0) {
            bodies.still_s[a ? contact.a : contact.b] = 0.0F;  // on a kinematic body that moves
        }
    }
    for (const std::uint32_t index : active_joints) {
        const JointEntry& entry = joints[index];
        if (!entry.alive) {
            continue;  // broke in this step
        }
        const bool a = entry.a != kNoIndex && bodies.simulated(entry.a);
        const bool b = bodies.simulated(entry.b);
        if (a && b) {
            sets_.join(bodies.solver_slot[entry.a], bodies.solver_slot[entry.b]);
        } else if (entry.a != kNoIndex && bodies.awake[a ? entry.b : entry.a] != 0) {
            bodies.still_s[a ? entry.a : entry.b] = 0.0F;  // held by a kinematic body that moves
        }
    }
    std::uint32_t islands = 0;
    for (std::size_t i = 0; i < list.size(); ++i) {
        const std::uint32_t root = sets_.root(static_cast<std::uint32_t>(i));
        islands += root == i ? 1 : 0;
        still_s_[root] = std::min(still_s_[root], bodies.still_s[list[i]]);
    }
    if (limits.after_s > 0.0F) {
        for (std::size_t i = 0; i < list.size(); ++i) {
            if (still_s_[sets_.root(static_cast<std::uint32_t>(i))] >= limits.after_s) {
                put_to_sleep(bodies, graph, list[i]);
            }
        }
    }
    for (const std::uint32_t row : list) {
        bodies.solver_slot[row] = 0;
    }
    return islands;
}

}  // namespace zoned::physics
