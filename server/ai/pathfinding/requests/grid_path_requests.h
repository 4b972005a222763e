// GridPathRequests: answers path requests over the cells of a zone's ground, spread over ticks.
#pragma once

#include "server/ai/pathfinding/flow_fields/crowd_paths.h"
#include "server/ai/pathfinding/grid/corner_pool.h"
#include "server/ai/pathfinding/grid/ground_map.h"
#include "server/ai/pathfinding/grid/work_units.h"
#include "server/ai/pathfinding/grid_search/grid_planner.h"
#include "server/ai/pathfinding/hierarchy/region_next_hop.h"
#include "server/ai/pathfinding/requests/path_provider.h"
#include "server/ai/pathfinding/requests/request_turns.h"
#include "shared/core/containers/id_table.h"

#include <array>
#include <functional>
#include <memory>
#include <optional>

namespace zoned::ai::pathfinding {

struct GridPathSettings {
    /// Work in a tick, in units of about 2 ns (work_units.h). The least work for the requests that
    /// are due is kept in reserve. The limit is exceeded where that least work is more than all. It
    /// is also exceeded by the single cost of a goal that cannot be reached.
    std::uint64_t work_per_tick = 1'000'000;
    /// Further work in a tick while the map's index is renewed after a change. Excess work of one
    /// part is subtracted from the next ticks.
    std::uint64_t index_work_per_tick = 200'000;
    /// An asker with a single request gets its path after at most this many ticks, whatever the
    /// load. Requests that come due beyond the work of a tick go from region to region, which is
    /// cheap.
    std::uint32_t longest_wait_ticks = 20;
    /// The most cells or corners that one search may look at, within the work of a tick; beyond,
    /// the path goes from region to region.
    std::uint32_t search_work = 20'000;
    /// A place in an obstacle is replaced by the nearest passable cell within this many cells.
    int reach_cells = 8;
    GridSearch search;  ///< kDefault: what suits the map
    IndexBounds index;
    /// An index that is expected to cost no more than this is made at the start, in units of about
    /// 2 ns. A larger one is begun once searches have cost as much: so all work together is at most
    /// twice the least, whatever comes.
    std::uint64_t index_at_start = 10'000'000;
    /// Tables of distances between regions that are kept. Where all regions together have no more,
    /// they are made beforehand.
    std::size_t tables = RegionNextHop::kTables;
    std::optional<pathfinding::CrowdPathSettings> crowding{};  ///< none: paths ignore crowds
};

/// A map alone, without doors or neighbouring zones; see GridPaths for these.
class GridPathRequests : public PathProvider {
  public:
    /// `most_open`: see GridPlanner::know_most_open(); may be null.
    explicit GridPathRequests(GroundMap map,
                              const GridPathSettings& settings = {},
                              const GridMap* most_open = nullptr);

    PathRequestId ask(const PathRequest& ask) final;
    void release(PathRequestId ticket) final;

    void turn_doors(std::span<const std::uint8_t> /*shut*/) override { change({}); }

    [[nodiscard]] bool knows(PathRequestId ticket) const final {
        return ticket.slot < slots_.size() && slots_[ticket.slot].round == ticket.round &&
               slots_[ticket.slot].taken;
    }

    void serve() final;
    [[nodiscard]] PathResult answer(PathRequestId ticket) const final;

    /// While the path is not ready, it leads from region to region.
    Spot heading(PathRequestId ticket, Spot at, float near_m) final;

    void see(PathRequestId ticket, Spot at, float /*at_y*/) final { slots_[ticket.slot].at = at; }

    [[nodiscard]] RequestEnds ends(PathRequestId ticket) const final {
        return {slots_[ticket.slot].at, slots_[ticket.slot].to};
    }

    [[nodiscard]] std::span<const std::uint32_t> answered() const final { return reported_; }

    [[nodiscard]] std::span<const std::uint32_t> requeued() const final { return requeued_; }

    [[nodiscard]] bool counts_bodies() const final { return crowd_ != nullptr && crowd_->looks(); }

    void count_bodies(std::span<const float> x, std::span<const float> z) final {
        crowd_->look(x, z);
    }

    /// A request that waits again gets another path only if that pays from the asker's place then.
    std::span<const std::uint32_t> review_crowds() final;
    [[nodiscard]] bool straight(Spot from, float from_y, Spot to, float to_y) const final;

    [[nodiscard]] bool contains(Spot place) const final { return grid_.contains(place); }

    /// The exit towards a place beyond the map. The candidates are reachable cells along the sides
    /// of the map that the place lies beyond. The exit gives the shortest two straight lines.
    MapExit straight_exit(Spot from, float from_y, Spot to) final;

    [[nodiscard]] bool settled() const override;
    [[nodiscard]] SavedPaths save() const override;
    std::string load(const SavedPaths& memory) override;

    [[nodiscard]] const PathCounts& counts() const final { return counts_; }

    [[nodiscard]] std::size_t bytes() const override;

    /// Changes cells of the map. From now on all answers are those of the changed map.
    /// - A path that is cut, in the part that its asker still has to go, is looked for anew (the
    ///   request waits again).
    /// - A path for which the opened cells may be a short cut is looked for anew; the asker follows
    ///   the old path until the new one is ready.
    /// - A request that could not reach its goal is looked for anew where its component was joined
    ///   with more, or a cell opened nearer to the goal.
    /// All others stay as they are. An index that was begun is renewed over the next ticks, and the
    /// hops for waiting agents in the next serve().
    void change(std::span<const CellChange> changes);

    /// True if nothing is left to be done on the index: it is that of the map as it is, or it was
    /// not worth its cost so far.
    [[nodiscard]] bool indexed() const { return indexed_; }

    [[nodiscard]] const GroundGrid& grid() const { return grid_; }

    [[nodiscard]] const GridPlanner& planner() const { return planner_; }

    /// True if a path leads from the cell nearest to a place to another cell.
    bool reaches(Spot from, Cell to);

    /// The length of the best path from the cell nearest to a place to another cell, m. Once the
    /// work of the tick is used up, it is the approximate length of a path from region to region.
    /// Nothing where no path leads there.
    std::optional<float> length(Spot from, Cell to);

    [[nodiscard]] const RegionNextHop& regions() const { return regions_; }

    /// The next step from a cell towards a goal, by the flow field that requests to this goal share
    /// now; empty where there is none. Valid until the next call of anything else.
    [[nodiscard]] std::function<Hop(Cell)> flow_to(Cell goal) const;

  protected:
    /// Counts further work of this tick.
    void spend(std::uint64_t units) { spent_ += units; }

  private:
    /// Units given to the index when no more are needed.
    static constexpr std::uint64_t kAllUnits = ~std::uint64_t{0};

    struct RequestSlot {
        std::uint32_t round = 0;
        std::uint32_t asker = 0;
        Spot at;  ///< place of the asker when last seen
        Spot to;
        Cell start;
        Cell goal;
        bool taken = false;
        bool waiting = false;
        bool usable = false;  ///< its corners form a path
        bool moved = false;   ///< the goal is replaced because it lies in an obstacle
        bool best = false;
        bool doubted = false;  ///< it waits for another path, to be taken if that pays
        PathOutcome outcome = PathOutcome::kUnreachable;
        CornerBlock corners;
        std::uint32_t next = 0;  ///< the corner that the asker heads for
        float length_m = 0.0F;
        Spot ahead;           ///< the place of that corner
        float rest_m = 0.0F;  ///< length of the path from there on
    };

    /// A set of the map's kBlocks x kBlocks blocks, as bits. It contains at least the blocks that a
    /// path crosses or touches.
    static constexpr unsigned kBlocks = 32;
    using Blocks = std::array<std::uint64_t, kBlocks * kBlocks / 64>;

    /// Next steps from all cells to a goal that many requests share.
    struct CachedFlowField {
        Place goal = kNoPlace;
        std::uint64_t used = 0;
        std::vector<Hop> hops;
    };

    /// Gap: the middles of the cells that a change opened, and the box around them.
    struct Gap {
        std::span<const Spot> middles;
        Spot low;
        Spot high;
    };

    /// Closed: the cells that a change closed, the box around them, and the blocks that they touch.
    struct Closed {
        std::span<const Cell> cells;
        FlowField::Window around;
        Blocks blocks;
    };

    static constexpr std::size_t kFields = 8;
    [[nodiscard]] SavedRequest saved_request(std::uint32_t number) const;
    void load(const SavedRequest& memory);
    /// The reason why the state does not fit this map; empty: it fits.
    [[nodiscard]] std::string defect_of_memory(const SavedPaths& memory) const;
    /// Answers requests within the tick's work, and all requests that are due.
    void serve_waiting();
    /// Keeps the least work for so many requests that are still due in this tick.
    void keep_back(std::uint32_t due);
    /// Writes the corners of the path into `cells_`; false where the tick's work ended before it
    /// was found.
    bool find(RequestSlot& slot, bool cheaply);
    bool find_by_field(RequestSlot& slot);
    bool find_around_crowds(RequestSlot& slot);
    /// True if a path around crowds costs so much less than the rest of its own path that it is
    /// worth taking.
    [[nodiscard]] bool pays(const RequestSlot& slot, std::uint64_t& work) const;
    bool find_by_planner(RequestSlot& slot);
    void find_by_regions(RequestSlot& slot);
    void prepare_table(Cell goal);
    /// Searches, and counts the work.
    GridAnswer search(const GridQuery& query);

    [[nodiscard]] bool nobody_asks() const { return free_.size() == slots_.size(); }

    void renew_index();
    /// Begins the index once searches have cost enough, and goes on with it.
    void advance_index();

    [[nodiscard]] std::uint64_t index_price() const {
        return kIndexUnits * planner_.map().places();
    }

    /// The reachable cell nearest to the goal, among the cells that stand for regions and the
    /// start.
    Cell nearest_middle(const RequestSlot& slot);
    /// Goes on from the last of `cells_` to a goal in the same region.
    void walk_within_region(Cell goal);
    /// Makes a field within the tick's work; true once it is complete.
    bool make_field(Cell goal);
    /// Appends the next cell.
    void append(Cell c, bool straight_on);
    /// Appends the cells on the hops to `cells_`.
    template <class HopAt>
    void walk(const HopAt& hop_at);
    void keep(std::uint32_t number);
    /// Removes the corners of a path.
    void drop(std::uint32_t number);
    /// Adds the blocks that the line between the middles of two cells crosses.
    void add_blocks(Blocks& blocks, Cell a, Cell b) const;
    void done(std::uint32_t number);
    void fail(std::uint32_t number, PathOutcome outcome);
    void wait(std::uint32_t number);
    void add_wanted(Place goal);
    void remove_wanted(Place goal);
    /// Prepares the hops of waiting requests that have none yet, within the tick's work.
    void lead_waiting();
    /// Finds the cells of an asker's place and its goal; false where there are none.
    bool find_ends(std::uint32_t number);
    /// Finds the ends of a waiting request again: the asker has walked on, and the map may have
    /// changed.
    bool refresh(std::uint32_t number);
    /// Fills opened_ and closed_; false where nothing changes.
    bool sort_changes(std::span<const CellChange> changes);
    [[nodiscard]] Gap gap() const;
    [[nodiscard]] Closed closed() const;
    /// Applies a change to the path of a request.
    void review(std::uint32_t number, bool near, const Gap& gap, const Closed& closed);
    [[nodiscard]] bool cut(const RequestSlot& slot, const Closed& closed) const;
    [[nodiscard]] bool leads_through(Spot from, Spot to, const Closed& closed) const;
    [[nodiscard]] bool may_be_shorter(const RequestSlot& slot, const Gap& gap) const;
    [[nodiscard]] bool may_come_nearer(const RequestSlot& slot, const Gap& gap, Spot end) const;
    /// Puts the requests that changes made wait into their queues.
    void queue_again();
    void settle_regions();
    [[nodiscard]] bool worth_a_field(const RequestSlot& slot) const;
    [[nodiscard]] Spot first_segment(const RequestSlot& slot, Spot at) const;

    GridPathSettings settings_;
    GroundGrid grid_;
    GridPlanner planner_;
    RegionNextHop regions_;
    CornerPool pool_;
    RequestTurns queue_;
    std::vector<RequestSlot> slots_;
    std::vector<Blocks> blocks_;  // by slot; no bits where there is no path
    unsigned block_shift_ = 0;    // shift from a cell's column or row to its block
    std::vector<std::uint32_t> free_;
    std::vector<std::uint32_t> answered_;  // answered since the last serve()
    std::vector<std::uint32_t> reported_;  // reported by the last serve()
    std::vector<std::uint32_t> requeued_;
    std::vector<std::uint32_t> to_queue_;  // requests that wait since a change and are in no queue
                                           // yet
    std::vector<std::uint32_t> unled_;     // requests that wait and have no table yet
    std::vector<Spot> opened_;             // middles of the cells that a change opened
    std::vector<Cell> closed_;             // cells that it closed
    std::vector<std::uint32_t> near_;      // slots that a change may concern, doubled; odd: for its
                                           // closed cells
    std::unique_ptr<pathfinding::CrowdPaths> crowd_;  // null: paths ignore crowds
    std::vector<std::uint32_t> doubted_;
    std::size_t next_review_ = 0;          // slot that is reviewed next
    std::uint64_t reviewed_round_ = 0;     // round of the crowds at the last review
    core::IdTable<std::uint32_t> wanted_;  // by place of a goal: number of waiting requests for it
    std::array<CachedFlowField, kFields> fields_;
    FlowField builder_;
    Place building_ = kNoPlace;
    std::uint64_t typical_work_ = 0;  // of a path by the planner
    std::uint64_t cheap_work_ = 0;    // of a path from region to region
    std::uint64_t budget_ = 0;        // work left in the tick, without the reserve
    bool searched_ = false;           // a search was made in this tick
    std::vector<Cell> cells_;
    FlowField near_goal_;
    bool indexed_ = true;
    bool renewing_ = false;            // the index is being made for a changed map
    std::uint64_t index_given_ = 0;    // units since the index was begun; 0: it was not yet
    std::uint64_t searched_work_ = 0;  // of searches before it was begun
    std::uint64_t spent_ = 0;
    std::uint64_t tick_ = 0;
    PathCounts counts_;
};

}  // namespace zoned::ai::pathfinding
