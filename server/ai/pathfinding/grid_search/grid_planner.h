// GridPlanner: paths on one grid map, by whichever method suits the map and the query.
#pragma once

#include "server/ai/pathfinding/grid/components.h"
#include "server/ai/pathfinding/grid/grid_path.h"
#include "server/ai/pathfinding/grid/grid_query.h"
#include "server/ai/pathfinding/grid/open_list.h"
#include "server/ai/pathfinding/grid_search/landmarks.h"
#include "server/ai/pathfinding/grid_search/subgoal_search.h"
#include "server/ai/pathfinding/hierarchy/hpa_graph.h"

#include <cstddef>
#include <optional>
#include <span>
#include <vector>

namespace zoned::ai::pathfinding {

/// What an index may cost. Counted, not timed: the same map gives the same index everywhere.
struct IndexBounds {
    std::size_t doors = 1'500'000;         ///< of all cells together
    std::uint32_t trees = 48;              ///< of shortest paths, from which hubs are chosen
    std::uint64_t tree_work = 40'000'000;  ///< neighbours that these trees look at
    HubLabels::Bounds labels;
    std::size_t landmark_bytes = 20'000'000;  ///< where there are no labels; 10 MB at 512 x 512
};

/// A map, its index, and memory for one query at a time. Deterministic; no allocation in plan()
/// once each method that is used has been used.
class GridPlanner {
  public:
    /// At most kMostPassable cells of the map are passable.
    explicit GridPlanner(GridMap map);
    GridPlanner(const GridPlanner&) = delete;  // resumable_task of its index know where it is
    GridPlanner& operator=(const GridPlanner&) = delete;

    /// What may ever be passable, the map included, where that is known beforehand: landmarks are
    /// of this from the first prepare() on, and the same whatever doors have done.
    void know_most_open(const GridMap& most) { landmark_map_ = most; }

    /// Builds the index for the map as it is. What exceeds a bound is left out: `can` tells.
    void prepare(const IndexBounds& bounds = {});

    /// As prepare(), in resumable_task: begins now, and is done once advance_index() says so.
    /// Answers are exact meanwhile, by whatever is there; a change drops what has been done so far.
    /// What has exceeded a bound is not tried again before one cell in kRetryShare has changed.
    void begin_index(const IndexBounds& bounds = {});

    static constexpr std::uint32_t kRetryShare = 64;

    /// Goes on for about so many units of some 2 ns. True where nothing is left to do.
    bool advance_index(std::uint64_t units);

    /// Units that the last advance_index() has taken.
    [[nodiscard]] std::uint64_t index_work() const { return index_work_; }

    /// Builds what kHierarchical needs. It follows changes by itself.
    void prepare_clusters();

    /// Changes cells on the map. The index is no longer true and is dropped, unless nothing
    /// changed; answers are exact all the same.
    void change(std::span<const CellChange> changes);

    /// Whether a path leads from one cell to another; false where either is blocked or off the map.
    bool joined(Cell a, Cell b);

    /// Whether what this passable cell reaches was joined by the last change() from parts that did
    /// not reach each other before; true where that is not known.
    [[nodiscard]] bool joined_anew(Cell c) const {
        return !components_followed_ || components_.joined_anew(map_.place(c));
    }

    /// Whether the method has what it needs.
    [[nodiscard]] bool can(GridMethod method) const;

    /// What kDefault is for the map as it is, where no straight line leads to the goal.
    [[nodiscard]] GridMethod choice() const;

    /// Finds a path; `path()` holds it until the next call (kFound, kPartial, kCutOff). The method
    /// is one that it can. A free straight line is always taken without any search.
    GridAnswer plan(const GridQuery& query, GridMethod method = GridMethod::kDefault);

    [[nodiscard]] const GridPath& path() const { return path_; }

    [[nodiscard]] const GridMap& map() const { return map_; }

    /// Memory of the index, without clusters.
    [[nodiscard]] std::size_t index_bytes() const;

    /// Null before prepare_clusters().
    [[nodiscard]] const HpaGraph* clusters() const { return clusters_ ? &*clusters_ : nullptr; }

  private:
    static constexpr std::uint64_t kNever = ~std::uint64_t{0};

    ResumableTask index(IndexBounds bounds);
    ResumableTask index_subgoals(IndexBounds bounds);
    [[nodiscard]] bool worth_a_try(std::uint64_t failed_at) const;
    void retire_index();
    void label_components();
    GridAnswer route(const GridQuery& query, GridMethod method);
    GridAnswer by_cells(const GridQuery& query, GridMethod method);
    GridAnswer by_subgoals(const GridQuery& query, bool labels);
    GridAnswer by_clusters(const GridQuery& query);

    /// Null where nothing is known.
    [[nodiscard]] const Landmarks* landmarks() const {
        return landmarks_.known() ? &landmarks_ : nullptr;
    }

    /// Appends the path that a search over cells has found.
    void append_chain(Place last);
    GridAnswer finished(PathOutcome outcome, std::uint32_t work) const;
    /// The passable cell nearest to `to`, as on an empty map, that `from` reaches.
    Cell nearest_reached(Cell from, Cell to, std::uint32_t& looked) const;

    GridMap map_;
    Components components_;
    bool components_true_ = false;
    bool components_followed_ = false;  // by the last change
    std::optional<Subgoals> subgoals_;
    std::optional<HubLabels> labels_;
    std::optional<Subgoals> old_subgoals_;  // to be given back
    std::optional<HubLabels> old_labels_;
    std::optional<HpaGraph> clusters_;
    SubgoalSearch subgoal_search_;
    LabelLookup lookup_;
    SearchSpace cells_;  // made at its first use
    GridPath path_;
    std::vector<Subgoal> stations_;
    std::vector<Place> chain_;
    std::vector<Cell> through_;
    std::vector<Subgoal> hub_order_;
    std::optional<GridMap> landmark_map_;   // all that was passable since landmarks were wanted
    Landmarks landmarks_;                   // of that
    std::optional<Subgoals> new_subgoals_;  // until they can be used
    std::optional<HubLabels> new_labels_;
    std::optional<IndexBounds> next_index_;  // to be begun once the last one is cleared up
    std::uint64_t changed_cells_ = 0;        // so far
    std::uint64_t no_subgoals_at_ = kNever;  // changed_cells_ when a bound was exceeded
    std::uint64_t no_labels_at_ = kNever;
    std::uint64_t index_work_ = 0;
    ResumableTask indexing_;  // last: goes before what it works on
};

}  // namespace zoned::ai::pathfinding
