#include "server/physics/effort.h"

#include "server/physics/contact_solver.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace zoned::physics {

namespace {

/// How long an island keeps a level that it no longer needs, s.
constexpr float kPatience = 0.5F;
/// A contact of at most so many steps is young.
constexpr std::uint8_t kYoung = 3;
/// One contact in this many may be served less well than it asks for ...
constexpr std::uint32_t kSparedShare = 64;
/// ... by up to this many levels.
constexpr std::size_t kSparedLevels = 2;

/// The lowest level whose 2^level substeps are at least as many.
std::uint8_t level_of(float substeps) {
    std::uint8_t level = 0;
    while (level + 1U < Effort::kLevels && static_cast<float>(1U << level) < substeps) {
        ++level;
    }
    return level;
}

/// The level that serves all contacts of an island but few, and those not too badly.
std::uint8_t level_of_island(const std::array<std::uint32_t, Effort::kLevels>& needs) {
    std::uint32_t total = 0;
    for (const std::uint32_t contacts : needs) {
        total += contacts;
    }
    std::size_t level = Effort::kLevels - 1;
    while (level > 0 && needs[level] == 0) {
        --level;
    }
    const std::size_t least = level > kSparedLevels ? level - kSparedLevels : 0;
    std::uint32_t spared = 0;
    while (level > least && (spared + needs[level]) * kSparedShare <= total) {
        spared += needs[level];
        --level;
    }
    return static_cast<std::uint8_t>(level);
}

}  // namespace

void Effort::reserve(std::size_t bodies, std::size_t contacts) {
    sets_.reserve(bodies);
    needs_.reserve(bodies);
    held_.reserve(bodies);
    patience_.reserve(bodies);
    batch_.reserve(contacts);
    sorted_.reserve(contacts);
}

std::uint8_t Effort::level_for(const Bodies& bodies,
                               const Pair& pair,
                               const Contact& contact,
                               const Budget& budget) {
    const float inv_a = bodies.inv_mass[pair.a];
    const float inv_b = bodies.inv_mass[pair.b];
    float force = 0.0F;
    if (pair.touching) {
        for (std::size_t i = 0; i < pair.points(); ++i) {
            force += contact.points[i].impulse;
        }
        force /= contact.substep_s;
    } else {
        const float lighter = inv_a > 0.0F && inv_b > 0.0F ? std::min(inv_a, inv_b) : inv_a + inv_b;
        force = budget.gravity_mps2 / lighter;
    }
    const float give = force * (inv_a + inv_b) / budget.error_m;  // 1 / s2
    const float rate = std::sqrt(give) / (2.0F * std::numbers::pi_v<float> * kContactRateShare);
    return level_of(budget.dt_s * std::max(rate, 1.0F / budget.longest_h_s));
}

/// Islands of the bodies that contacts hold: sets over their places in `awake_list`.
void Effort::join(Bodies& bodies, const ContactGraph& graph, std::span<const std::uint32_t> list) {
    const auto& awake = bodies.awake_list;
    sets_.reset(awake.size());
    for (std::size_t i = 0; i < awake.size(); ++i) {
        bodies.solver_slot[awake[i]] = static_cast<std::uint32_t>(i);
    }
    for (const std::uint32_t index : list) {
        const Pair& pair = graph.pair(index);
        if (bodies.simulated(pair.a) && bodies.simulated(pair.b)) {
            sets_.join(bodies.solver_slot[pair.a], bodies.solver_slot[pair.b]);
        }
    }
}

/// From what each island needs now and had before to what it gets.
void Effort::settle(Bodies& bodies, float dt) {
    const auto& awake = bodies.awake_list;
    for (std::size_t i = 0; i < awake.size(); ++i) {
        const std::uint32_t root = sets_.root(static_cast<std::uint32_t>(i));
        const std::uint32_t row = awake[i];
        if (bodies.effort[row] > held_[root]) {
            held_[root] = bodies.effort[row];
            patience_[root] = bodies.effort_patience[row];
        } else if (bodies.effort[row] == held_[root]) {
            patience_[root] = std::max(patience_[root], bodies.effort_patience[row]);
        }
    }
    const auto patience = static_cast<std::uint8_t>(std::clamp(kPatience / dt, 1.0F, 250.0F));
    for (std::size_t i = 0; i < awake.size(); ++i) {
        if (sets_.root(static_cast<std::uint32_t>(i)) != i) {
            continue;
        }
        const std::uint8_t needed = level_of_island(needs_[i].level);
        if (needed >= held_[i]) {
            held_[i] = needed;
            patience_[i] = patience;
        } else if (patience_[i] > 0) {
            --patience_[i];
        } else {
            --held_[i];
            patience_[i] = patience;
        }
    }
    for (std::size_t i = 0; i < awake.size(); ++i) {
        const std::uint32_t root = sets_.root(static_cast<std::uint32_t>(i));
        bodies.effort[awake[i]] = held_[root];
        bodies.effort_patience[awake[i]] = patience_[root];
    }
}

void Effort::plan(Bodies& bodies,
                  const ContactGraph& graph,
                  std::span<const std::uint32_t> list,
                  const Budget& budget) {
    join(bodies, graph, list);
    const std::size_t count = bodies.awake_list.size();
    needs_.assign(count, Needs{});
    held_.assign(count, 0);
    patience_.assign(count, 0);
    for (const std::uint32_t index : list) {
        const Pair& pair = graph.pair(index);
        const std::uint32_t row = bodies.simulated(pair.a) ? pair.a : pair.b;
        Needs& needs = needs_[sets_.root(bodies.solver_slot[row])];
        ++needs.level[level_for(bodies, pair, graph[index], budget)];
        needs.young += pair.age <= kYoung ? 1 : 0;
    }
    settle(bodies, budget.dt_s);
    sort(bodies, graph, list);
    for (const std::uint32_t row : bodies.awake_list) {
        bodies.solver_slot[row] = 0;
    }
}

void Effort::sort(const Bodies& bodies,
                  const ContactGraph& graph,
                  std::span<const std::uint32_t> list) {
    batch_.resize(list.size());
    sorted_.resize(list.size());
    first_.fill(0);
    for (std::size_t i = 0; i < list.size(); ++i) {
        const Pair& pair = graph.pair(list[i]);
        const std::uint32_t row = bodies.simulated(pair.a) ? pair.a : pair.b;
        const Needs& needs = needs_[sets_.root(bodies.solver_slot[row])];
        std::uint32_t total = 0;
        for (const std::uint32_t contacts : needs.level) {
            total += contacts;
        }
        const bool young = 2 * needs.young > total;
        batch_[i] = static_cast<std::uint8_t>(2 * bodies.effort[row] + (young ? 1 : 0));
        ++first_[batch_[i] + 2U];
    }
    for (std::size_t i = 2; i < first_.size(); ++i) {
        first_[i] += first_[i - 1];
    }
    for (std::size_t i = 0; i < list.size(); ++i) {
        sorted_[first_[batch_[i] + 1U]++] = list[i];
    }
}

}  // namespace zoned::physics
