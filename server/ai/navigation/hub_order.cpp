#include "server/ai/navigation/hub_labels.h"
#include "shared/core/rng.h"

#include <algorithm>
#include <queue>
#include <utility>

namespace zoned::ai::navigation {

namespace {

/// Shortest ways from one subgoal to all others. `below` counts the subgoals whose way leads
/// through each, itself among them, as far as no hub covers them.
class WayTree {
  public:
    WayTree(const Subgoals& graph, Subgoal root, SearchSpace& space)
        : from_(graph.size(), kNoSubgoal),
          below_(graph.size(), 0) {
        std::vector<Subgoal> order;
        space.begin();
        space.reach(root, 0, root);
        space.open.push(root, 0);
        while (!space.open.empty()) {
            const Subgoal s = space.open.pop();
            const Cost g = space.cost(s);
            order.push_back(s);
            from_[s] = s == root ? kNoSubgoal : space.from(s);
            for (const Subgoal n : graph.neighbours(s)) {
                const Cost cost = g + graph.cost(s, n);
                if (cost < space.cost(n)) {
                    space.reach(n, cost, s);
                    space.open.push(n, cost);
                }
            }
        }
        children_.resize(graph.size());
        for (auto s = order.rbegin(); s != order.rend(); ++s) {
            ++below_[*s];
            if (from_[*s] != kNoSubgoal) {
                below_[from_[*s]] += below_[*s];
                children_[from_[*s]].push_back(*s);
            }
        }
    }

    [[nodiscard]] std::uint32_t below(Subgoal s) const { return below_[s]; }

    /// All ways through s are covered from now on; `lost(t, n)` is told that n fewer lead through
    /// t.
    template <class Lost>
    void cover(Subgoal s, const Lost& lost) {
        const std::uint32_t gone = below_[s];
        if (gone == 0) {
            return;
        }
        for (Subgoal up = from_[s]; up != kNoSubgoal; up = from_[up]) {
            below_[up] -= gone;
            lost(up, gone);
        }
        stack_.assign(1, s);
        while (!stack_.empty()) {
            const Subgoal t = stack_.back();
            stack_.pop_back();
            lost(t, below_[t]);
            below_[t] = 0;
            for (const Subgoal c : children_[t]) {
                if (below_[c] != 0) {
                    stack_.push_back(c);
                }
            }
        }
    }

  private:
    std::vector<Subgoal> from_;
    std::vector<std::uint32_t> below_;
    std::vector<std::vector<Subgoal>> children_;
    std::vector<Subgoal> stack_;
};

}  // namespace

std::vector<Subgoal> hub_order(const Subgoals& graph, std::uint32_t trees) {
    std::vector<Subgoal> order;
    hub_order(graph, trees, order).advance(~std::uint64_t{0});
    return order;
}

Slices hub_order(const Subgoals& graph, std::uint32_t trees, std::vector<Subgoal>& order) {
    constexpr std::uint64_t kEdgeUnits = 4;
    std::vector<std::uint64_t> weight(graph.size(), 0);
    std::vector<WayTree> sample;
    order.clear();
    if (graph.size() != 0) {
        SearchSpace space;
        space.resize(graph.size());
        core::Rng rng(1);
        for (std::uint32_t i = 0; i < std::min(trees, graph.size()); ++i) {
            sample.emplace_back(graph, rng.below(graph.size()), space);
            for (Subgoal s = 0; s < graph.size(); ++s) {
                weight[s] += sample.back().below(s);
            }
            co_await Spent{kEdgeUnits * (graph.edges() + graph.size())};
        }
    }
    // Weights only fall: an entry that is out of date goes back with what it weighs now. Ties go to
    // the smaller number.
    using Entry = std::pair<std::uint64_t, Subgoal>;
    std::priority_queue<Entry> heaviest;
    for (Subgoal s = 0; s < graph.size(); ++s) {
        heaviest.emplace(weight[s], ~s);
    }
    order.reserve(graph.size());
    while (!heaviest.empty()) {
        const auto [was, inverse] = heaviest.top();
        const Subgoal s = ~inverse;
        heaviest.pop();
        if (was != weight[s]) {
            heaviest.emplace(weight[s], inverse);
            continue;
        }
        order.push_back(s);
        std::uint64_t covered = 0;
        for (WayTree& tree : sample) {
            tree.cover(s, [&weight, &covered](Subgoal t, std::uint32_t n) {
                weight[t] -= n;
                ++covered;
            });
        }
        co_await Spent{kEdgeUnits * (1 + covered + sample.size())};
    }
}

}  // namespace zoned::ai::navigation
