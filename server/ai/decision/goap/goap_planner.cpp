#include "server/ai/decision/goap/goap_planner.h"

#include "shared/core/assert.h"

#include <algorithm>
#include <bit>
#include <functional>
#include <limits>

namespace zoned::ai::goap {

namespace {

constexpr std::uint32_t kNever = std::numeric_limits<std::uint32_t>::max();
constexpr std::uint32_t kNobody = std::numeric_limits<std::uint32_t>::max();

bool within(const Literals& some, const Literals& all) {
    return ((some.yes & ~all.yes) | (some.no & ~all.no)) == 0;
}

}  // namespace

Actions::Actions(const Domain& domain) : all_facts_(domain.all_facts()) {
    ZONED_ASSERT(domain.facts.size() <= kMaxFacts && domain.actions.size() <= kMaxActions,
                 "facts and actions have a bit each");
    for (std::size_t a = 0; a < domain.actions.size(); ++a) {
        const Action& action = domain.actions[a];
        actions_.push_back({action.needs, action.makes, action.cost});
        for (std::size_t f = 0; f < kMaxFacts; ++f) {
            makers_yes_[f] |= (action.makes.yes >> f & 1) << a;
            makers_no_[f] |= (action.makes.no >> f & 1) << a;
        }
    }
}

GoapPlanner::GoapPlanner(std::uint32_t bound) : bound_(bound) {
    ZONED_ASSERT(bound >= 1 && bound <= 65536, "a search may create some nodes");
    nodes_.resize(bound + 1);
    slots_.resize(std::bit_ceil(2 * (bound + 1)));
    open_.reserve(4 * (bound + 1));
}

void GoapPlanner::plan(const Actions& actions, FactSet from, const Literals& goal, Plan& plan) {
    if (++search_ == 0) {
        std::fill(slots_.begin(), slots_.end(), PlanSlot{});
        search_ = 1;
    }
    plan.size = 0;
    plan.cost = 0;
    plan.created = 0;
    node_count_ = 0;
    open_.clear();
    too_long_ = false;
    full_ = false;
    relax(actions, from);
    const std::uint32_t least = guess(goal);
    if (least == kNever) {
        plan.verdict = Verdict::kUnreachable;
        return;
    }
    nodes_[0] = {goal, 0, least, kNobody, 0, 0, false};
    node_count_ = 1;
    slot_of(goal) = {search_, 0};
    const bool found = search(actions, plan);
    plan.created = node_count_;
    if (!found) {
        plan.verdict =
            too_long_ || full_ || node_count_ > bound_ ? Verdict::kCutOff : Verdict::kUnreachable;
    }
}

/// Layers of facts by their least cost, each fact as if it were alone, cheapest first (Dijkstra's
/// algorithm over actions).
void GoapPlanner::relax(const Actions& actions, FactSet from) {
    Literals reached{from & actions.all_facts_, ~from & actions.all_facts_};
    std::array<std::uint32_t, kMaxActions> due;  // written before it is read
    const std::size_t count = actions.actions_.size();
    std::uint64_t waiting =
        count == kMaxActions ? ~std::uint64_t{0} : (std::uint64_t{1} << count) - 1;
    std::uint64_t begun = 0;
    std::uint32_t cost = 0;
    usable_ = 0;
    layer_count_ = 0;
    while (true) {
        layers_[layer_count_++] = {reached, cost};
        for (std::uint64_t rest = waiting; rest != 0; rest &= rest - 1) {
            const auto a = static_cast<std::size_t>(std::countr_zero(rest));
            if (within(actions.actions_[a].needs, reached)) {
                waiting ^= rest & (~rest + 1);
                begun |= rest & (~rest + 1);
                due[a] = cost + actions.actions_[a].cost;
            }
        }
        usable_ |= begun;
        std::uint32_t next = kNever;
        for (std::uint64_t rest = begun; rest != 0; rest &= rest - 1) {
            const auto a = static_cast<std::size_t>(std::countr_zero(rest));
            if (within(actions.actions_[a].makes, reached)) {
                begun ^= rest & (~rest + 1);  // brings nothing new any more
            } else {
                next = std::min(next, due[a]);
            }
        }
        if (next == kNever) {
            return;
        }
        for (std::uint64_t rest = begun; rest != 0; rest &= rest - 1) {
            const auto a = static_cast<std::size_t>(std::countr_zero(rest));
            if (due[a] == next) {
                reached.yes |= actions.actions_[a].makes.yes;
                reached.no |= actions.actions_[a].makes.no;
            }
        }
        cost = next;
    }
}

std::uint32_t GoapPlanner::guess(const Literals& needs) const {
    for (std::size_t k = 0; k < layer_count_; ++k) {
        if (within(needs, layers_[k].reached)) {
            return layers_[k].cost;
        }
    }
    return kNever;
}

/// The cheapest node is kept out of the heap where it is known to be the cheapest. It is the best
/// child of a node, with the same sum as its parent.
bool GoapPlanner::search(const Actions& actions, Plan& plan) {
    std::uint32_t at = 0;
    while (at != kNobody) {
        if (nodes_[at].guess == 0) {  // actions cost something: the world is as this node needs it
            write(at, plan);
            return true;
        }
        nodes_[at].closed = true;
        at = expand(actions, at);
        if (node_count_ > bound_ || full_) {
            return false;
        }
        if (at == kNobody) {
            at = pop();
        }
    }
    return false;
}

std::uint64_t GoapPlanner::makers(const Actions& actions, const Literals& needs) const {
    std::uint64_t makers = 0;
    for (std::uint64_t rest = needs.yes; rest != 0; rest &= rest - 1) {
        makers |= actions.makers_yes_[static_cast<std::size_t>(std::countr_zero(rest))];
    }
    for (std::uint64_t rest = needs.no; rest != 0; rest &= rest - 1) {
        makers |= actions.makers_no_[static_cast<std::size_t>(std::countr_zero(rest))];
    }
    return makers & usable_;
}

/// Creates the nodes from which one action leads to node `at`. Returns the one to look at next
/// where no other can be better, or kNobody.
std::uint32_t GoapPlanner::expand(const Actions& actions, std::uint32_t at) {
    const PlanNode from = nodes_[at];
    if (from.steps == kMaxSteps) {
        too_long_ = true;
        return kNobody;
    }
    std::uint32_t best = kNobody;
    for (std::uint64_t rest = makers(actions, from.needs); rest != 0; rest &= rest - 1) {
        const auto a = static_cast<std::size_t>(std::countr_zero(rest));
        const Actions::Flat& action = actions.actions_[a];
        if (((action.makes.yes & from.needs.no) | (action.makes.no & from.needs.yes)) != 0) {
            continue;  // it undoes a needed fact
        }
        const Literals needs{(from.needs.yes & ~action.makes.yes) | action.needs.yes,
                             (from.needs.no & ~action.makes.no) | action.needs.no};
        if ((needs.yes & needs.no) != 0) {
            continue;
        }
        const std::uint32_t least = guess(needs);
        if (least == kNever) {
            continue;
        }
        const std::uint32_t cost = from.cost + action.cost;
        PlanSlot& slot = slot_of(needs);
        std::uint32_t node = slot.node;
        if (slot.search != search_) {
            if (node_count_ > bound_) {
                return kNobody;
            }
            node = node_count_++;
            slot = {search_, node};
        } else if (nodes_[node].closed || nodes_[node].cost <= cost) {
            continue;
        }
        nodes_[node] = {needs,
                        cost,
                        least,
                        at,
                        static_cast<std::uint8_t>(a),
                        static_cast<std::uint8_t>(from.steps + 1),
                        false};
        if (cost + least == from.cost + from.guess &&
            (best == kNobody || least < nodes_[best].guess)) {
            std::swap(best, node);
        }
        if (node != kNobody) {
            push(node);
        }
    }
    return best;
}

GoapPlanner::PlanSlot& GoapPlanner::slot_of(const Literals& needs) {
    const std::size_t last = slots_.size() - 1;
    const std::uint64_t bits =
        needs.yes * 0x9E3779B97F4A7C15ull ^ std::rotr(needs.no * 0xC2B2AE3D27D4EB4Full, 29);
    std::size_t at = (bits ^ bits >> 32) & last;
    while (slots_[at].search == search_ && !(nodes_[slots_[at].node].needs == needs)) {
        at = (at + 1) & last;
    }
    return slots_[at];
}

void GoapPlanner::push(std::uint32_t node) {
    const std::uint64_t sum = nodes_[node].cost + nodes_[node].guess;
    if (open_.size() == open_.capacity()) {
        full_ = true;
        return;
    }
    // Of equal sums the one nearest to the world, then the one that was created first.
    const std::uint64_t guess = std::min<std::uint32_t>(nodes_[node].guess, 0xFFFF);
    open_.push_back(sum << 33 | guess << 17 | node);
    std::push_heap(open_.begin(), open_.end(), std::greater<>());
}

std::uint32_t GoapPlanner::pop() {
    while (!open_.empty()) {
        std::pop_heap(open_.begin(), open_.end(), std::greater<>());
        const auto node = static_cast<std::uint32_t>(open_.back() & 0x1FFFF);
        open_.pop_back();
        if (!nodes_[node].closed) {
            return node;
        }
    }
    return kNobody;
}

void GoapPlanner::write(std::uint32_t node, Plan& plan) const {
    plan.verdict = Verdict::kPlanned;
    plan.cost = nodes_[node].cost;
    for (; nodes_[node].parent != kNobody; node = nodes_[node].parent) {
        plan.action[plan.size++] = nodes_[node].action;
    }
}

}  // namespace zoned::ai::goap
