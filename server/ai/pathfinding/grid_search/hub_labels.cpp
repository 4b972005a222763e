#include "server/ai/pathfinding/grid_search/hub_labels.h"

#include "shared/core/assert.h"

#include <algorithm>
#include <utility>

namespace zoned::ai::pathfinding {

namespace {

constexpr std::size_t kMostHubs = 65'535;

/// Searches from each hub in turn; a search goes on only where no earlier hub explains the cost.
class Labeler {
  public:
    Labeler(const Subgoals& graph, const HubLabels::Bounds& bounds)
        : graph_(graph),
          bounds_(bounds),
          labels_(graph.size()),
          cost_to_hub_(graph.size(), kNoCost) {
        space_.resize(graph.size());
    }

    void begin_hub(std::uint16_t hub, Subgoal root) {
        hub_ = hub;
        root_ = root;
        for (const HubLabel& l : labels_[root]) {
            cost_to_hub_[l.hub] = l.cost;
        }
        space_.begin();
        space_.reach(root, 0, root);
        space_.open.push(root, 0);
    }

    /// Continues from at most so many subgoals. True once all are reached.
    bool spread_hub(std::uint32_t count) {
        for (; count != 0 && !space_.open.empty(); --count) {
            const Subgoal s = space_.open.pop();
            const Cost g = space_.cost(s);
            ++looked_at_;
            if (!explained(s, g)) {
                labels_[s].push_back({hub_, static_cast<std::uint16_t>(space_.from(s)), g});
                ++count_;
                spread(s, g);
            }
        }
        return space_.open.empty();
    }

    void end_hub() {
        for (const HubLabel& l : labels_[root_]) {
            cost_to_hub_[l.hub] = kNoCost;
        }
    }

    [[nodiscard]] bool within_bounds() const {
        return work_ <= bounds_.work && count_ <= bounds_.labels;
    }

    /// Gives the labels of one back.
    void clear(Subgoal s) { labels_[s] = {}; }

    [[nodiscard]] std::size_t subgoals() const { return labels_.size(); }

    /// In units of about 2 ns, all that was done so far.
    [[nodiscard]] std::uint64_t units() const { return 2 * work_ + kLookUnits * looked_at_; }

    [[nodiscard]] const std::vector<HubLabel>& of(Subgoal s) const { return labels_[s]; }

    [[nodiscard]] std::size_t count() const { return count_; }

  private:
    bool explained(Subgoal s, Cost g) {
        work_ += labels_[s].size();
        return std::any_of(labels_[s].begin(), labels_[s].end(), [this, g](const HubLabel& l) {
            const Cost there = cost_to_hub_[l.hub];
            return there != kNoCost && there + l.cost <= g;
        });
    }

    void spread(Subgoal s, Cost g) {
        const std::span<const Subgoal> neighbours = graph_.neighbours(s);
        work_ += neighbours.size();
        for (const Subgoal n : neighbours) {
            const Cost cost = g + graph_.cost(s, n);
            if (cost < space_.cost(n)) {
                space_.reach(n, cost, s);
                space_.open.push(n, cost);
            }
        }
    }

    const Subgoals& graph_;
    HubLabels::Bounds bounds_;
    SearchSpace space_;
    std::vector<std::vector<HubLabel>> labels_;
    std::vector<Cost> cost_to_hub_;                  // from the root, by hub
    static constexpr std::uint64_t kLookUnits = 60;  // of a subgoal

    std::uint64_t work_ = 0;  // labels and neighbours
    std::uint64_t looked_at_ = 0;
    std::size_t count_ = 0;
    std::uint16_t hub_ = 0;
    Subgoal root_ = 0;
};

}  // namespace

std::optional<HubLabels> HubLabels::build(const Subgoals& graph,
                                          std::span<const Subgoal> order,
                                          const Bounds& bounds) {
    std::optional<HubLabels> built;
    const std::vector<Subgoal> hubs(order.begin(), order.end());
    build(graph, hubs, bounds, built).advance(~std::uint64_t{0});
    return built;
}

ResumableTask HubLabels::build(const Subgoals& graph,
                               const std::vector<Subgoal>& order,
                               Bounds bounds,
                               std::optional<HubLabels>& built) {
    ZONED_ASSERT(order.size() == graph.size(), "each subgoal has a place in the order");
    built.reset();
    if (order.size() > kMostHubs) {
        co_return;
    }
    constexpr std::uint32_t kSpreadAtOnce = 128;
    constexpr std::uint64_t kCopyUnits = 2;    // of a label
    constexpr std::uint64_t kClearUnits = 40;  // of a subgoal
    Labeler labeler(graph, bounds);
    bool cancelled = co_await Spent{memory_units(labeler.subgoals() * 64)};
    for (std::size_t i = 0; i < labeler.subgoals() && !cancelled && labeler.within_bounds(); ++i) {
        labeler.begin_hub(static_cast<std::uint16_t>(i), order[i]);
        bool done = false;
        while (!done && !cancelled && labeler.within_bounds()) {
            const std::uint64_t before = labeler.units();
            done = labeler.spread_hub(kSpreadAtOnce);
            cancelled = co_await Spent{kClearUnits + labeler.units() - before};
        }
        labeler.end_hub();
    }
    const bool keeps = !cancelled && labeler.within_bounds();
    HubLabels result;
    if (keeps) {
        result.labels_.reserve(labeler.count());
        result.first_.reserve(labeler.subgoals() + 1);
    }
    for (Subgoal s = 0; s < labeler.subgoals(); ++s) {
        const std::vector<HubLabel>& of = labeler.of(s);
        const std::uint64_t units =
            kClearUnits + (keeps ? kCopyUnits * of.size() : 0) + memory_units(8 * of.size());
        if (keeps && !cancelled) {
            result.first_.push_back(static_cast<std::uint32_t>(result.labels_.size()));
            result.labels_.insert(result.labels_.end(), of.begin(), of.end());
        }
        labeler.clear(s);
        cancelled = co_await Spent{units};
    }
    if (keeps && !cancelled) {
        result.first_.push_back(static_cast<std::uint32_t>(result.labels_.size()));
        built = std::move(result);
    }
}

const HubLabel* HubLabels::look_up(Subgoal s, std::uint16_t hub) const {
    const std::span<const HubLabel> labels = of(s);
    const auto found =
        std::lower_bound(labels.begin(), labels.end(), hub, [](const HubLabel& l, std::uint16_t h) {
            return l.hub < h;
        });
    return found != labels.end() && found->hub == hub ? &*found : nullptr;
}

std::size_t HubLabels::bytes() const {
    return first_.capacity() * sizeof(std::uint32_t) + labels_.capacity() * sizeof(HubLabel);
}

}  // namespace zoned::ai::pathfinding
