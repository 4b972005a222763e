#include "server/ai/pathfinding/grid_search/hub_labels.h"
#include "shared/core/rng.h"

#include <algorithm>
#include <queue>
#include <utility>

namespace zoned::ai::pathfinding {

namespace {

/// Shortest paths from one subgoal to all others. `below` counts the subgoals whose path leads
/// through each, itself among them, as far as no hub covers them.
class PathTree {
  public:
    PathTree(const Subgoals& graph, Subgoal root, SearchSpace& space)
        : root_(root),
          nodes_(graph.size()) {
        space.begin();
        space.reach(root, 0, root);
        space.open.push(root, 0);
    }

    /// Continues the search from at most so many subgoals; `order` gathers them. Returns the units
    /// of work.
    std::uint64_t spread(const Subgoals& graph,
                         SearchSpace& space,
                         std::uint32_t count,
                         std::vector<Subgoal>& order) {
        std::uint64_t units = 0;
        for (; count != 0 && !space.open.empty(); --count) {
            const Subgoal s = space.open.pop();
            const Cost g = space.cost(s);
            order.push_back(s);
            nodes_[s].from = s == root_ ? kNoSubgoal : space.from(s);
            const std::span<const Subgoal> neighbours = graph.neighbours(s);
            for (const Subgoal n : neighbours) {
                const Cost cost = g + graph.cost(s, n);
                if (cost < space.cost(n)) {
                    space.reach(n, cost, s);
                    space.open.push(n, cost);
                }
            }
            units += kSpreadUnits + kEdgeUnits * neighbours.size();
        }
        return units;
    }

    /// Called once all are reached: sums up from the ends of paths; `weight` of each gains the
    /// weights below it.
    void sum_up(std::span<const Subgoal> order, std::span<std::uint64_t> weight) {
        for (auto s = order.rbegin(); s != order.rend(); ++s) {
            Node& node = nodes_[*s];
            weight[*s] += ++node.below;
            if (node.from != kNoSubgoal) {
                Node& above = nodes_[node.from];
                above.below += node.below;
                node.beside = std::exchange(above.child, *s);
            }
        }
    }

    /// Marks all paths through s as covered; `lost(t, n)` is called where n fewer paths lead
    /// through t.
    template <class Lost>
    void cover(Subgoal s, const Lost& lost) {
        const std::uint32_t gone = nodes_[s].below;
        if (gone == 0) {
            return;
        }
        for (Subgoal up = nodes_[s].from; up != kNoSubgoal; up = nodes_[up].from) {
            nodes_[up].below -= gone;
            lost(up, gone);
        }
        stack_.assign(1, s);
        while (!stack_.empty()) {
            const Subgoal t = stack_.back();
            stack_.pop_back();
            lost(t, nodes_[t].below);
            nodes_[t].below = 0;
            for (Subgoal c = nodes_[t].child; c != kNoSubgoal; c = nodes_[c].beside) {
                if (nodes_[c].below != 0) {
                    stack_.push_back(c);
                }
            }
        }
    }

    /// Gives its memory back.
    void clear() {
        nodes_ = {};
        stack_ = {};
    }

    /// The memory of a tree.
    static std::size_t bytes(const Subgoals& graph) { return graph.size() * sizeof(Node); }

  private:
    struct Node {
        Subgoal from = kNoSubgoal;
        std::uint32_t below = 0;
        Subgoal child = kNoSubgoal;   ///< one whose path comes from here
        Subgoal beside = kNoSubgoal;  ///< another that comes from where this one does
    };

    static constexpr std::uint64_t kSpreadUnits = 60;
    static constexpr std::uint64_t kEdgeUnits = 8;

    Subgoal root_;
    std::vector<Node> nodes_;
    std::vector<Subgoal> stack_;
};

}  // namespace

std::vector<Subgoal> hub_order(const Subgoals& graph, std::uint32_t trees) {
    std::vector<Subgoal> order;
    hub_order(graph, trees, order).advance(~std::uint64_t{0});
    return order;
}

ResumableTask hub_order(const Subgoals& graph, std::uint32_t trees, std::vector<Subgoal>& order) {
    constexpr std::uint32_t kSpreadAtOnce = 256;
    constexpr std::uint64_t kSumUnits = 16;    // of a subgoal of a tree
    constexpr std::uint64_t kCoverUnits = 24;  // covering one subgoal
    constexpr std::uint64_t kLookUnits = 4;    // looking at one tree
    std::vector<std::uint64_t> weight(graph.size(), 0);
    std::vector<PathTree> sample;
    sample.reserve(trees);
    order.clear();
    bool cancelled = false;
    if (graph.size() != 0) {
        SearchSpace space;
        space.resize(graph.size());
        std::vector<Subgoal> reached;
        reached.reserve(graph.size());
        core::Rng rng(1);
        for (std::uint32_t i = 0; i < std::min(trees, graph.size()) && !cancelled; ++i) {
            sample.emplace_back(graph, rng.below(graph.size()), space);
            cancelled = co_await Spent{memory_units(PathTree::bytes(graph))};
            reached.clear();
            while (!cancelled && !space.open.empty()) {
                const std::uint64_t units =
                    sample.back().spread(graph, space, kSpreadAtOnce, reached);
                cancelled = co_await Spent{units};
            }
            if (!cancelled) {
                sample.back().sum_up(reached, weight);
                cancelled = co_await Spent{kSumUnits * reached.size()};
            }
        }
    }
    // Weights only fall: an outdated entry goes back with its present weight. Ties go to the
    // smaller number.
    using Entry = std::pair<std::uint64_t, Subgoal>;
    std::priority_queue<Entry> heaviest;
    for (Subgoal s = 0; s < weight.size() && !cancelled; ++s) {
        heaviest.emplace(weight[s], ~s);
    }
    order.reserve(weight.size());
    while (!heaviest.empty() && !cancelled) {
        const auto [was, inverse] = heaviest.top();
        const Subgoal s = ~inverse;
        heaviest.pop();
        if (was != weight[s]) {
            heaviest.emplace(weight[s], inverse);
            continue;
        }
        order.push_back(s);
        std::uint64_t covered = 0;
        for (PathTree& tree : sample) {
            tree.cover(s, [&weight, &covered](Subgoal t, std::uint32_t n) {
                weight[t] -= n;
                ++covered;
            });
        }
        cancelled = co_await Spent{kCoverUnits * (1 + covered) + kLookUnits * sample.size()};
    }
    const std::uint64_t tree_units = 1 + memory_units(weight.size() * 16);
    for (PathTree& tree : sample) {
        tree.clear();
        co_await Spent{tree_units};
    }
}

}  // namespace zoned::ai::pathfinding
