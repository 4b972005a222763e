// HubLabels: distances between subgoals, and paths along them, by looking them up.
#pragma once

#include "server/ai/pathfinding/grid/open_list.h"
#include "server/ai/pathfinding/grid_search/subgoals.h"

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

namespace zoned::ai::pathfinding {

/// Subgoals in the order in which they become hubs: those that lie on most shortest paths first.
/// Trees of shortest paths from a sample of subgoals stand for all; who lies on most paths of the
/// sample that no hub covers yet is next (Delling, Goldberg, Pajor and Werneck, "Robust distance
/// queries on massive networks", ESA 2014, section 4). Deterministic.
std::vector<Subgoal> hub_order(const Subgoals& graph, std::uint32_t trees);

/// The same in resumable_task, into `order`.
ResumableTask hub_order(const Subgoals& graph, std::uint32_t trees, std::vector<Subgoal>& order);

/// What a subgoal knows of one hub. Hubs are numbered by their order.
struct HubLabel {
    std::uint16_t hub;
    std::uint16_t next;  ///< neighbour on the way there; itself at the hub
    Cost cost;           ///< of that path
};

/// Pruned landmark labels (Akiba, Iwata and Yoshida, "Fast exact shortest-path distance queries on
/// large networks by pruned landmark labeling", SIGMOD 2013, sections 4 and 6): of any two subgoals
/// that reach each other some hub that both know lies on a shortest path between them.
class HubLabels {
  public:
    /// What building may cost before it is given up: the map is then not one for labels.
    struct Bounds {
        std::size_t labels = 1'000'000;
        std::uint64_t work = 400'000'000;  ///< labels and neighbours looked at
    };

    /// Nothing where a bound is exceeded, or there are more than 65,535 subgoals.
    static std::optional<HubLabels> build(const Subgoals& graph,
                                          std::span<const Subgoal> order,
                                          const Bounds& bounds);

    /// The same in resumable_task; all but `bounds` stays where and as it is until all is done.
    static ResumableTask build(const Subgoals& graph,
                               const std::vector<Subgoal>& order,
                               Bounds bounds,
                               std::optional<HubLabels>& built);

    /// Ascending by hub.
    [[nodiscard]] std::span<const HubLabel> of(Subgoal s) const {
        return {labels_.data() + first_[s], labels_.data() + first_[s + 1]};
    }

    /// What `s` knows of a hub; null where it knows nothing.
    [[nodiscard]] const HubLabel* look_up(Subgoal s, std::uint16_t hub) const;

    [[nodiscard]] std::size_t bytes() const;

  private:
    HubLabels() = default;

    std::vector<std::uint32_t> first_;
    std::vector<HubLabel> labels_;
};

}  // namespace zoned::ai::pathfinding
