#include "server/physics/solver/substep_policy.h"

#include "server/physics/solver/contact_solver.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace zoned::physics {

namespace {

/// How long an island keeps a level that it no longer needs, s: a change of level disturbs stacks.
constexpr float kPatience = 0.5F;
/// The same with joints. A need that comes back within the step is no loss there: see TornIslands.
constexpr float kJointedPatience = 0.1F;
/// A joint may gape by this share of the budget: a body that it holds swings faster within the step
/// than when the step began.
constexpr float kJointShare = 0.02F;
/// A contact of a thin body may yield by this share of the ball that fits into it: a card that
/// leans on another slides off where their edges sink in.
constexpr float kThinShare = 0.1F;
/// A spring swings by no more than this within a substep, rad: 1 % of its frequency.
constexpr float kSpringTurn = 0.5F;
/// A body swings under the force of a joint by no more than this within a substep, rad: chains of
/// light links that hold a heavy body swing fast. From 2 on the scheme is unstable.
constexpr float kSwingTurn = 0.75F;
/// Force of a joint beyond the weight of the heaviest body under this acceleration is no load:
/// joints that contradict each other pull the more the stiffer they are, m/s2.
constexpr float kMostPull = 100.0F;
/// A contact of at most so many steps is young.
constexpr std::uint8_t kYoung = 3;
/// Contacts that one thread looks at at a time.
constexpr std::size_t kContactGrain = 128;
/// One contact in this many may be served less well than it asks for ...
constexpr std::uint32_t kSparedShare = 64;
/// ... by up to this many levels.
constexpr std::size_t kSparedLevels = 2;

/// Visits of contacts that one island gets in a step, at most: about half a second of them.
/// Thousands of bodies in one place would ask for a hundred times as many.
constexpr std::uint32_t kMostVisits = 1U << 20;

/// Masses in an island that is left to an exact solver differ by more than this: a body pinched
/// between equals asks for as much, and has no answer.
constexpr float kStiffRatio = 1500.0F;

std::uint32_t total_of(const std::array<std::uint32_t, SubstepPolicy::kLevels>& needs) {
    std::uint32_t total = 0;
    for (const std::uint32_t contacts : needs) {
        total += contacts;
    }
    return total;
}

/// The highest level that keeps within kMostVisits.
std::uint8_t most_level(std::uint32_t contacts) {
    std::uint8_t level = SubstepPolicy::kLevels - 1;
    while (level > 0 && (contacts << level) > kMostVisits) {
        --level;
    }
    return level;
}

/// The lowest level whose 2^level substeps are at least as many; kLevels: none does.
std::uint8_t level_of(float substeps) {
    std::uint8_t level = 0;
    while (level < SubstepPolicy::kLevels && static_cast<float>(1U << level) < substeps) {
        ++level;
    }
    return level;
}

/// The level that serves all contacts of an island but few, and those not too badly.
std::uint8_t level_of_island(const std::array<std::uint32_t, SubstepPolicy::kLevels>& needs) {
    const std::uint32_t total = total_of(needs);
    std::size_t level = SubstepPolicy::kLevels - 1;
    while (level > 0 && needs[level] == 0) {
        --level;
    }
    const std::size_t least = level > kSparedLevels ? level - kSparedLevels : 0;
    std::uint32_t spared = 0;
    while (level > least && (spared + needs[level]) * kSparedShare <= total) {
        spared += needs[level];
        --level;
    }
    return std::min(static_cast<std::uint8_t>(level), most_level(total));
}

/// Angular frequency at which a body swings about its centre under a force along an arm, rad/s: the
/// most that its inertia about axes across the arm allows.
float swing_rate(const Bodies& bodies, std::uint32_t row, const Vec3& arm, float force) {
    const float square = arm.squaredNorm();
    if (square == 0.0F) {
        return 0.0F;
    }
    Vec3 across = Vec3::Constant(square);
    if (!bodies.tilted(row)) {
        across -= arm.cwiseAbs2();
    }
    const float give = bodies.inv_inertia[row].cwiseProduct(across).maxCoeff();
    return std::sqrt(force * std::max(give, 0.0F) / std::sqrt(square));
}

}  // namespace

bool SubstepPolicy::IslandNeeds::fit_for_exact() const {
    return !jointed && !rolls_stiffly && total_of(level) <= kExactContacts &&
           most_inv_mass > kStiffRatio * least_inv_mass;
}

float SubstepPolicy::IslandNeeds::inv_mass_scale_of(float inv_mass, std::uint8_t held) const {
    const float most = kHeaviest * least_inv_mass;
    const bool at_the_end = held >= most_level(total_of(level));
    return at_the_end && !jointed && inv_mass > most ? most / inv_mass : 1.0F;
}

bool SubstepPolicy::IslandNeeds::mostly_young() const {
    return 2 * young > total_of(level);
}

void SubstepPolicy::reserve(std::size_t bodies, std::size_t contacts) {
    sets_.reserve(bodies);
    needs_.reserve(bodies);
    held_.reserve(bodies);
    patience_.reserve(bodies);
    level_.reserve(contacts);
    batch_.reserve(contacts);
    sorted_.reserve(contacts);
    exact_keys_.reserve(contacts);
    exact_contacts_.reserve(contacts);
    exact_.reserve(contacts);
}

std::uint8_t SubstepPolicy::level_for(const Bodies& bodies,
                                      const Pair& pair,
                                      const Contact& contact,
                                      const SubstepTargets& budget) {
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
    float error = budget.error_m;
    for (const std::uint32_t row : {pair.a, pair.b}) {
        if (bodies.simulated(row)) {
            error = std::min(error, kThinShare * bodies.inner[row]);
        }
    }
    const float give = force * (inv_a + inv_b) / error;  // 1 / s2
    const float rate = std::sqrt(give) / (2.0F * std::numbers::pi_v<float> * kContactRateShare);
    return level_of(budget.dt_s * std::max(rate, 1.0F / budget.longest_h_s));
}

/// Islands of the bodies that contacts hold: sets over their places in `awake_list`.
void SubstepPolicy::join(Bodies& bodies,
                         const ContactGraph& graph,
                         std::span<const std::uint32_t> list,
                         const JointTable& table,
                         std::span<const std::uint32_t> joints) {
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
    for (const std::uint32_t index : joints) {
        const JointEntry& entry = table[index];
        if (entry.a != kNoIndex && bodies.simulated(entry.a) && bodies.simulated(entry.b)) {
            sets_.join(bodies.solver_slot[entry.a], bodies.solver_slot[entry.b]);
        }
    }
}

std::uint8_t SubstepPolicy::level_of_joint(const Bodies& bodies,
                                           const JointEntry& entry,
                                           float most_force,
                                           const SubstepTargets& budget) {
    float need = 1.0F / budget.longest_h_s;
    const float force = std::min(entry.force_n, most_force);
    const auto consider = [&](std::uint32_t row, const Vec3& arm) {
        if (row != kNoIndex) {
            const float rate = bodies.angular_velocity[row].norm();
            need = std::max(need,
                            rate * std::sqrt(0.125F * arm.norm() / (kJointShare * budget.error_m)));
            need = std::max(need, swing_rate(bodies, row, arm, force) / kSwingTurn);
        }
    };
    consider(entry.a, entry.joint.local_a);
    consider(entry.b, entry.joint.local_b);
    if (entry.joint.def.kind == JointKind::kSpring) {
        constexpr float kSwing = 2.0F * std::numbers::pi_v<float> / kSpringTurn;
        need = std::max(need, kSwing * entry.joint.def.spring_hz);
    }
    return level_of(budget.dt_s * need);
}

/// Computes the substeps of each island from its present need and its last number.
void SubstepPolicy::settle(Bodies& bodies, float dt) {
    const auto& awake = bodies.awake_list;
    for (std::size_t i = 0; i < awake.size(); ++i) {
        const std::uint32_t root = sets_.root(static_cast<std::uint32_t>(i));
        const std::uint32_t row = awake[i];
        if (bodies.substep_level[row] > held_[root]) {
            held_[root] = bodies.substep_level[row];
            patience_[root] = bodies.substep_patience[row];
        } else if (bodies.substep_level[row] == held_[root]) {
            patience_[root] = std::max(patience_[root], bodies.substep_patience[row]);
        }
    }
    const auto patience_of = [dt](const IslandNeeds& needs) {
        const float seconds = needs.jointed ? kJointedPatience : kPatience;
        return static_cast<std::uint8_t>(std::clamp(seconds / dt, 1.0F, 250.0F));
    };
    for (std::size_t i = 0; i < awake.size(); ++i) {
        if (sets_.root(static_cast<std::uint32_t>(i)) != i) {
            continue;
        }
        const IslandNeeds& needs = needs_[i];
        const std::uint8_t patience = patience_of(needs);
        const bool fit = needs.fit_for_exact();
        const std::uint8_t most = fit ? kExactLevel : most_level(total_of(needs.level));
        const std::uint8_t needed =
            fit && needs.level.back() > 0 ? kExactLevel : level_of_island(needs.level);
        if (needed >= held_[i]) {
            held_[i] = needed;
            patience_[i] = patience;
        } else if (held_[i] > most) {
            held_[i] = most;
        } else if (patience_[i] > 0) {
            --patience_[i];
        } else {
            --held_[i];
            patience_[i] = patience;
        }
    }
    island_.resize(bodies.rows());
    for (std::size_t i = 0; i < awake.size(); ++i) {
        const std::uint32_t root = sets_.root(static_cast<std::uint32_t>(i));
        island_[awake[i]] = root;
        bodies.substep_level[awake[i]] = held_[root];
        bodies.inv_mass_scale[awake[i]] =
            needs_[root].inv_mass_scale_of(bodies.inv_mass[awake[i]], held_[root]);
        bodies.substep_patience[awake[i]] = patience_[root];
    }
}

void SubstepPolicy::plan(Bodies& bodies,
                         const ContactGraph& graph,
                         std::span<const std::uint32_t> list,
                         const JointTable& table,
                         std::span<const std::uint32_t> joints,
                         const SubstepTargets& budget,
                         compute::Team& team) {
    level_.resize(list.size());
    team.run(list.size(), kContactGrain, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
            level_[i] = level_for(bodies, graph.pair(list[i]), graph[list[i]], budget);
        }
    });
    join(bodies, graph, list, table, joints);
    const std::size_t count = bodies.awake_list.size();
    needs_.assign(count, IslandNeeds{});
    held_.assign(count, 0);
    patience_.assign(count, 0);
    const auto row_of_contact = [&](std::uint32_t index) {
        const Pair& pair = graph.pair(index);
        return bodies.simulated(pair.a) ? pair.a : pair.b;
    };
    const auto row_of_joint = [&](std::uint32_t index) {
        return bodies.simulated(table[index].b) ? table[index].b : table[index].a;
    };
    const auto needs_of = [&](std::uint32_t row) -> IslandNeeds& {
        return needs_[sets_.root(bodies.solver_slot[row])];
    };
    for (std::size_t i = 0; i < list.size(); ++i) {
        IslandNeeds& needs = needs_of(row_of_contact(list[i]));
        needs.ask(level_[i]);
        const Pair& pair = graph.pair(list[i]);
        needs.young += pair.age <= kYoung ? 1 : 0;
        needs.rolls_stiffly |= graph[list[i]].grip.rolls_stiffly();
        for (const std::uint32_t row : {pair.a, pair.b}) {
            if (bodies.simulated(row)) {
                needs.note_mass(bodies.inv_mass[row]);
            }
        }
    }
    for (const std::uint32_t index : joints) {
        IslandNeeds& needs = needs_of(row_of_joint(index));
        needs.jointed = true;
        for (const std::uint32_t row : {table[index].a, table[index].b}) {
            if (row != kNoIndex && bodies.simulated(row)) {
                needs.note_mass(bodies.inv_mass[row]);
            }
        }
    }
    for (const std::uint32_t index : joints) {
        IslandNeeds& needs = needs_of(row_of_joint(index));
        const float most_force = kMostPull / needs.least_inv_mass;
        needs.ask(level_of_joint(bodies, table[index], most_force, budget));
    }
    substep_limited_ = 0;
    for (const IslandNeeds& needs : needs_) {
        substep_limited_ += needs.substep_limited && !needs.fit_for_exact() ? 1 : 0;
    }
    settle(bodies, budget.dt_s);
    sort(bodies, list, row_of_contact, sorted_, first_);
    list_exact(bodies, row_of_contact);
    sort(bodies, joints, row_of_joint, sorted_joints_, first_joint_);
    for (const std::uint32_t row : bodies.awake_list) {
        bodies.solver_slot[row] = 0;
    }
}

std::size_t SubstepPolicy::jointed_visits() const {
    std::size_t visits = 0;
    for (std::size_t i = 0; i < kBatches; ++i) {
        const SubstepBatch some = batch(i);
        if (!some.joints.empty()) {
            visits += (some.contacts.size() + some.joints.size()) *
                      static_cast<std::size_t>(some.substeps);
        }
    }
    return visits;
}

template <class RowOf>
void SubstepPolicy::sort(const Bodies& bodies,
                         std::span<const std::uint32_t> list,
                         RowOf&& row_of,
                         std::vector<std::uint32_t>& sorted,
                         std::array<std::uint32_t, kBatches + 3>& first) {
    batch_.resize(list.size());
    sorted.resize(list.size());
    first.fill(0);
    for (std::size_t i = 0; i < list.size(); ++i) {
        const std::uint32_t row = row_of(list[i]);
        const IslandNeeds& needs = needs_[sets_.root(bodies.solver_slot[row])];
        const bool exact = bodies.substep_level[row] == kExactLevel && needs.fit_for_exact();
        const int level = std::min<int>(bodies.substep_level[row], kLevels - 1);
        const std::uint32_t visits = total_of(needs.level) << level;
        const bool young = needs.mostly_young() && visits <= kMostVisits / kYoungIterations;
        const int batch = 4 * level + (needs.jointed ? 2 : 0) + (young ? 1 : 0);
        batch_[i] = static_cast<std::uint8_t>(exact ? kBatches : batch);
        ++first[batch_[i] + 2U];
    }
    for (std::size_t i = 2; i < first.size(); ++i) {
        first[i] += first[i - 1];
    }
    for (std::size_t i = 0; i < list.size(); ++i) {
        sorted[first[batch_[i] + 1U]++] = list[i];
    }
}

/// The contacts that no batch has, island by island.
template <class RowOf>
void SubstepPolicy::list_exact(const Bodies& bodies, RowOf&& row_of) {
    exact_keys_.clear();
    exact_contacts_.clear();
    exact_.clear();
    for (std::uint32_t i = first_[kBatches]; i < first_[kBatches + 1]; ++i) {
        const std::uint32_t root = sets_.root(bodies.solver_slot[row_of(sorted_[i])]);
        exact_keys_.push_back(static_cast<std::uint64_t>(root) << 32 | i);
    }
    std::sort(exact_keys_.begin(), exact_keys_.end());
    for (std::size_t i = 0; i < exact_keys_.size(); ++i) {
        const auto root = static_cast<std::uint32_t>(exact_keys_[i] >> 32);
        const auto place = static_cast<std::uint32_t>(i);
        if (i == 0 || exact_keys_[i - 1] >> 32 != root) {
            exact_.push_back({place, place, needs_[root].mostly_young()});
        }
        exact_.back().end = place + 1;
        exact_contacts_.push_back(sorted_[static_cast<std::uint32_t>(exact_keys_[i])]);
    }
}

}  // namespace zoned::physics
