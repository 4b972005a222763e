// GridPlanner: plans paths on one grid map, by the method that suits the map and the query.
#pragma once

#include "server/ai/pathfinding/grid/components.h"
#include "server/ai/pathfinding/grid/grid_path.h"
#include "server/ai/pathfinding/grid/grid_query.h"
#include "server/ai/pathfinding/grid/open_list.h"
#include "server/ai/pathfinding/grid_search/landmarks.h"
#include "server/ai/pathfinding/grid_search/subgoal_search.h"

#include <cstddef>
#include <optional>
#include <span>
#include <vector>

namespace zoned::ai::pathfinding {

/// The most cost of an index. It is counted, not timed, so the same map gives the same index
/// everywhere.
struct IndexBounds {
    std::size_t doors = 1'500'000;         ///< doors of all cells together
    std::uint32_t trees = 48;              ///< shortest-path trees from which hubs are chosen
    std::uint64_t tree_work = 40'000'000;  ///< neighbours that these trees look at
    HubLabels::Bounds labels;
    std::size_t landmark_bytes = 20'000'000;  ///< landmarks where there are no labels; 10 MB at 512
                                              ///< x 512
};

/// A map, its index, and memory for one query at a time. Deterministic; plan() does not allocate
/// once each method in use has been used.
class GridPlanner {
  public:
    /// At most kMostPassable cells of the map may be passable.
    explicit GridPlanner(GridMap map);
    GridPlanner(const GridPlanner&) = delete;  // the index's resumable task holds its address
    GridPlanner& operator=(const GridPlanner&) = delete;

    /// Sets the cells that may ever be passable, the map included, where they are known beforehand.
    /// Landmarks are made of these from the first prepare() on, and stay the same whatever doors
    /// have done.
    void know_most_open(const GridMap& most) { landmark_map_ = most; }

    /// The search of all queries that name none, from now on. Where it needs no index, none is
    /// built. Before the first prepare().
    void use(const GridSearch& search) { search_ = search; }

    /// Finds which cells reach each other, for joined(); the first query that needs it does so too.
    void label_components();

    /// Builds the index for the map as it is. Parts that exceed a bound are left out; see can().
    void prepare(const IndexBounds& bounds = {});

    /// As prepare(), but as a resumable task: it begins now and is done when advance_index()
    /// returns true. Answers are exact meanwhile, by the methods that are ready. A change drops the
    /// work done so far. A part that exceeded a bound is not tried again before one cell in
    /// kRetryShare has changed.
    void begin_index(const IndexBounds& bounds = {});

    static constexpr std::uint32_t kRetryShare = 64;

    /// Goes on for about so many units of some 2 ns. True where nothing is left to do.
    bool advance_index(std::uint64_t units);

    /// Stops making the index and frees it, in one go; answers stay exact.
    void drop_index();

    /// Units that the last advance_index() has taken.
    [[nodiscard]] std::uint64_t index_work() const { return index_work_; }

    /// Changes cells on the map. The index is then out of date and is dropped, unless nothing
    /// changed; answers stay exact.
    void change(std::span<const CellChange> changes);

    /// True if a path leads from one cell to another; false where either is blocked or off the map.
    bool joined(Cell a, Cell b);

    /// True if the last change() joined this passable cell's component from parts that were apart
    /// before; also true where that is unknown.
    [[nodiscard]] bool joined_anew(Cell c) const {
        return !components_followed_ || components_.joined_anew(map_.place(c));
    }

    /// True if the method has all it needs.
    [[nodiscard]] bool can(GridMethod method) const;

    /// The method that kDefault stands for on the present map, where no straight line leads to the
    /// goal: that of use(), or the one that suits the map.
    [[nodiscard]] GridMethod choice() const;

    /// Finds a path; `path()` holds it until the next call (kFound, kPartial, kCutOff). can(method)
    /// must hold. A free straight line is always taken without any search.
    /// With kDefault the weight is that of use().
    GridAnswer plan(const GridQuery& query, GridMethod method = GridMethod::kDefault);

    [[nodiscard]] const GridPath& path() const { return path_; }

    [[nodiscard]] const GridMap& map() const { return map_; }

    /// Memory of the index, bytes.
    [[nodiscard]] std::size_t index_bytes() const;

  private:
    static constexpr std::uint64_t kNever = ~std::uint64_t{0};

    ResumableTask index(IndexBounds bounds);
    ResumableTask index_subgoals(IndexBounds bounds);
    [[nodiscard]] bool worth_a_try(std::uint64_t failed_at) const;
    void retire_index();
    GridAnswer route(const GridQuery& query, GridMethod method);
    GridAnswer search_by(const GridQuery& query, GridMethod method);
    GridAnswer by_cells(const GridQuery& query, GridMethod method);
    GridAnswer by_subgoals(const GridQuery& query, bool labels);

    /// Null where nothing is known.
    [[nodiscard]] const Landmarks* landmarks() const {
        return landmarks_.known() ? &landmarks_ : nullptr;
    }

    /// Appends the path that a search over cells has found.
    void append_chain(Place last);
    GridAnswer finished(PathOutcome outcome, std::uint32_t work) const;
    /// The passable cell nearest to `to`, as on an empty map, among the cells that `from` reaches.
    Cell nearest_reached(Cell from, Cell to, std::uint32_t& looked) const;

    GridSearch search_;
    GridMap map_;
    Components components_;
    bool components_true_ = false;
    bool components_followed_ = false;  // by the last change
    std::optional<Subgoals> subgoals_;
    std::optional<HubLabels> labels_;
    std::optional<Subgoals> old_subgoals_;  // still to be freed
    std::optional<HubLabels> old_labels_;
    SubgoalSearch subgoal_search_;
    LabelLookup lookup_;
    SearchSpace cells_;  // made at its first use
    GridPath path_;
    std::vector<Subgoal> stations_;
    std::vector<Place> chain_;
    std::vector<Subgoal> hub_order_;
    std::optional<GridMap> landmark_map_;   // all cells that were passable since landmarks were
                                            // wanted
    Landmarks landmarks_;                   // made of landmark_map_
    std::optional<Subgoals> new_subgoals_;  // until they can be used
    std::optional<HubLabels> new_labels_;
    std::optional<IndexBounds> next_index_;  // to be begun once the last one is freed
    std::uint64_t changed_cells_ = 0;        // number so far
    std::uint64_t no_subgoals_at_ = kNever;  // changed_cells_ when a bound was exceeded
    std::uint64_t no_labels_at_ = kNever;
    std::uint64_t index_work_ = 0;
    ResumableTask indexing_;  // last, so that it is destroyed before the members that it works on
};

}  // namespace zoned::ai::pathfinding
