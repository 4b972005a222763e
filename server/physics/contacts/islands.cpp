#include "server/physics/contacts/islands.h"

#include <algorithm>

namespace zoned::physics {

namespace {

/// A body that stays within this of a place, m and rad, for so many times longer than a still one
/// has to be still, may sleep as well: what is still may go farther in its time.
constexpr float kSettledShift = 0.01F;
constexpr float kSettledTurn = 0.02F;
constexpr float kSettledLonger = 8.0F;
/// Faster than this many times the sleep speeds nothing settles.
constexpr float kUnsettled = 20.0F;

bool slower(const Bodies& bodies, std::uint32_t row, float speed, float spin) {
    return bodies.velocity[row].squaredNorm() < speed * speed &&
           bodies.angular_velocity[row].squaredNorm() < spin * spin;
}

bool left_its_place(const Bodies& bodies, std::uint32_t row) {
    const Vec3 shift = bodies.position[row] - bodies.settled_at[row];
    const float cosine = bodies.orientation[row].dot(bodies.settled_turn[row]);  // of half the turn
    return shift.squaredNorm() > kSettledShift * kSettledShift ||
           1.0F - cosine * cosine > 0.25F * kSettledTurn * kSettledTurn;
}

/// How long the body has been still, and how long in one place. While it is still, nobody needs to
/// know the place.
void note_rest(Bodies& bodies, std::uint32_t row, const Islands::Limits& limits) {
    const bool still = slower(bodies, row, limits.speed, limits.spin);
    bodies.still_s[row] = still ? bodies.still_s[row] + limits.dt : 0.0F;
    float& settled_s = bodies.settled_s[row];
    if (!still && !slower(bodies, row, kUnsettled * limits.speed, kUnsettled * limits.spin)) {
        settled_s = 0.0F;
    } else if (settled_s > 0.0F && (still || !left_its_place(bodies, row))) {
        settled_s += limits.dt;
    } else {
        bodies.settled_at[row] = bodies.position[row];
        bodies.settled_turn[row] = bodies.orientation[row];
        settled_s = limits.dt;
    }
}

}  // namespace

void Waker::wake(Bodies& bodies, ContactGraph& graph, const JointTable& joints, std::uint32_t row) {
    if (!bodies.is_dynamic(row)) {
        return;
    }
    bodies.stir(row);
    if (bodies.awake[row] != 0) {
        return;
    }
    stack_.clear();
    stack_.push_back(row);
    bodies.mark_awake(row);
    while (!stack_.empty()) {
        const std::uint32_t at = stack_.back();
        stack_.pop_back();
        bodies.stir(at);
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
        note_rest(bodies, row, limits);
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
            bodies.stir(a ? contact.a : contact.b);  // on a kinematic body that moves
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
            bodies.stir(a ? entry.a : entry.b);  // held by a kinematic body that moves
        }
    }
    std::uint32_t islands = 0;
    for (std::size_t i = 0; i < list.size(); ++i) {
        const std::uint32_t root = sets_.root(static_cast<std::uint32_t>(i));
        islands += root == i ? 1 : 0;
        const float settled_s = bodies.settled_s[list[i]] / kSettledLonger;
        still_s_[root] = std::min(still_s_[root], std::max(bodies.still_s[list[i]], settled_s));
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
