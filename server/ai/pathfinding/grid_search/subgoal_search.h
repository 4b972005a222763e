// Subgoal search: paths among subgoals, by A* (SubgoalSearch) or by labels (LabelLookup).
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

    /// `best` becomes the subgoals of the path, in order. False where there is no path or max_work
    /// is exceeded: `best` then leads to the visited subgoal nearest to the goal. Landmarks as in
    /// search_jump_points(); may be null.
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

/// Finds the path by looking up the labels of the doors of start and goal.
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
    /// Sums of a mark and costs do not overflow.
    static constexpr std::uint32_t kFirstMark = ~0U / 2;

    /// By hub: the least cost from the start, below a mark. The mark falls with each query, so
    /// values of earlier queries are larger than any of this one.
    std::vector<std::uint64_t> from_start_;
    std::uint32_t mark_ = kFirstMark;
};

}  // namespace zoned::ai::pathfinding
