// HubLabels: distances between subgoals, and paths along them, by look-up.
#pragma once

#include "server/ai/pathfinding/grid/open_list.h"
#include "server/ai/pathfinding/grid_search/subgoals.h"

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

namespace zoned::ai::pathfinding {

/// Subgoals in the order in which they become hubs: the ones on most shortest paths come first.
/// Trees of shortest paths from a sample of subgoals stand for all. The next hub is the subgoal on
/// most paths of the sample that no hub covers yet. Deterministic. Source: Delling, Goldberg, Pajor
/// and Werneck, "Robust distance queries on massive networks", ESA 2014, section 4.
std::vector<Subgoal> hub_order(const Subgoals& graph, std::uint32_t trees);

/// The same as a resumable task, into `order`.
ResumableTask hub_order(const Subgoals& graph, std::uint32_t trees, std::vector<Subgoal>& order);

/// HubLabel: a subgoal's path to one hub. Hubs are numbered by their order.
struct HubLabel {
    std::uint16_t hub;
    std::uint16_t next;  ///< neighbour on the path there; itself at the hub
    Cost cost;           ///< of that path
};

/// Pruned landmark labels. For any two subgoals that reach each other, some hub in both label lists
/// lies on a shortest path between them. Source: Akiba, Iwata and Yoshida, "Fast exact
/// shortest-path distance queries on large networks by pruned landmark labeling", SIGMOD 2013,
/// sections 4 and 6.
class HubLabels {
  public:
    /// The most cost of building; beyond it building is given up, and the map does not suit labels.
    struct Bounds {
        std::size_t labels = 1'000'000;
        std::uint64_t work = 400'000'000;  ///< labels and neighbours looked at
    };

    /// Nothing where a bound is exceeded, or there are more than 65,535 subgoals.
    static std::optional<HubLabels> build(const Subgoals& graph,
                                          std::span<const Subgoal> order,
                                          const Bounds& bounds);

    /// The same as a resumable task. All arguments but `bounds` must stay unchanged and in place
    /// until it is done.
    static ResumableTask build(const Subgoals& graph,
                               const std::vector<Subgoal>& order,
                               Bounds bounds,
                               std::optional<HubLabels>& built);

    /// Ascending by hub.
    [[nodiscard]] std::span<const HubLabel> of(Subgoal s) const {
        return {labels_.data() + first_[s], labels_.data() + first_[s + 1]};
    }

    /// The label of `s` for a hub; null where it has none.
    [[nodiscard]] const HubLabel* look_up(Subgoal s, std::uint16_t hub) const;

    [[nodiscard]] std::size_t bytes() const;

  private:
    HubLabels() = default;

    std::vector<std::uint32_t> first_;
    std::vector<HubLabel> labels_;
};

}  // namespace zoned::ai::pathfinding
