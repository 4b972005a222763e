// Paths among subgoals: by A*, or by labels.
#pragma once

#include "server/ai/pathfinding/grid/grid_query.h"
#include "server/ai/pathfinding/grid_search/hub_labels.h"
#include "server/ai/pathfinding/grid_search/landmarks.h"

#include <vector>

namespace zoned::ai::pathfinding {

/// A* among subgoals, from the doors of the start to those of the goal. Start and goal are passable
/// and free_line(start, goal) is false.
class SubgoalSearch {
  public:
    void resize(const Subgoals& graph);

    /// `best` becomes the subgoals of the path, in order. False where there is none or max_work is
    /// exceeded: `best` then leads to the subgoal nearest to the goal that was looked at. Landmarks
    /// as of search_jump_points(); may be null.
    bool run(const GridMap& map,
             const Subgoals& graph,
             const Landmarks* landmarks,
             const GridQuery& query,
             std::vector<Subgoal>& best,
             std::uint32_t& work);

  private:
    SearchSpace space_;
    std::vector<Cost> to_goal_;  // of doors of the goal, else kNoCost
};

/// The path by looking up what the doors of start and goal know of hubs.
class LabelLookup {
  public:
    void resize(const Subgoals& graph);

    /// As SubgoalSearch::run, without a search: false only where no path joins them. `looked` grows
    /// by the labels looked at.
    bool run(const GridMap& map,
             const Subgoals& graph,
             const HubLabels& labels,
             const GridQuery& query,
             std::vector<Subgoal>& best,
             std::uint32_t& looked);

  private:
    /// Sums of a mark and costs don't overflow.
    static constexpr std::uint32_t kFirstMark = ~0U / 2;

    /// By hub: the least cost from the start, below a mark that falls with each query, so that
    /// values of earlier queries are larger than any of this one.
    std::vector<std::uint64_t> from_start_;
    std::uint32_t mark_ = kFirstMark;
};

}  // namespace zoned::ai::pathfinding
