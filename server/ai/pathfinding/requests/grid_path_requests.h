// GridPathRequests: path requests over the cells of a zone's ground, worked out over ticks.
#pragma once

#include "server/ai/pathfinding/flow_fields/crowd_paths.h"
#include "server/ai/pathfinding/grid/corner_pool.h"
#include "server/ai/pathfinding/grid/ground_map.h"
#include "server/ai/pathfinding/grid_search/grid_planner.h"
#include "server/ai/pathfinding/hierarchy/region_next_hop.h"
#include "server/ai/pathfinding/requests/path_provider.h"
#include "server/ai/pathfinding/requests/request_turns.h"

#include <array>
#include <memory>
#include <optional>

namespace zoned::ai::pathfinding {

struct GridPathSettings {
    /// Of a tick, in units of about 2 ns (work_units.h). Of that as much is kept for those who are
    /// due as they need at least; it is exceeded where this is more than all, and by what a goal
    /// that can't be reached takes once.
    std::uint64_t work_per_tick = 1'000'000;
    /// Of a tick besides, as long as the map's index is renewed after a change. What a part of it
    /// takes beyond is left out of the next ticks.
    std::uint64_t index_work_per_tick = 200'000;
    /// Who has asked for one path alone has it after so many ticks, whatever the load: requests
    /// that come due beyond the work of a tick go from area to area, which is cheap.
    std::uint32_t longest_wait_ticks = 20;
    /// Cells or corners that one search may look at, and no more than the work of a tick allows;
    /// beyond, the path goes from area to area.
    std::uint32_t search_work = 20'000;
    /// A place in an obstacle stands for the nearest passable cell within so many.
    int reach_cells = 8;
    IndexBounds index;
    std::optional<pathfinding::CrowdPathSettings> crowding{};  ///< none: crowds are no matter
};

/// A map by itself, which has no doors and no zones around it; see GridPaths.
class GridPathRequests : public PathProvider {
  public:
    /// Prepares the map's index. `most_open`: GridPlanner::know_most_open(); may be null.
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

    /// As long as the path is not there, it leads from region to region.
    Spot heading(PathRequestId ticket, Spot at, float near_m) final;

    void see(PathRequestId ticket, Spot at, float /*at_y*/) final { slots_[ticket.slot].at = at; }

    [[nodiscard]] std::span<const std::uint32_t> answered() const final { return told_; }

    [[nodiscard]] std::span<const std::uint32_t> requeued() const final { return requeued_; }

    [[nodiscard]] bool counts_bodies() const final { return crowd_ != nullptr && crowd_->looks(); }

    void count_bodies(std::span<const float> x, std::span<const float> z) final {
        crowd_->look(x, z);
    }

    /// Who waits again gets another path only if that pays from where it is then.
    std::span<const std::uint32_t> review_crowds() final;
    [[nodiscard]] bool straight(Spot from, float from_y, Spot to, float to_y) const final;

    [[nodiscard]] bool contains(Spot place) const final { return grid_.contains(place); }

    /// Of the cells that can be reached along the sides of the map that the place lies beyond, the
    /// one by which two straight lines lead there soonest.
    MapExit straight_exit(Spot from, float from_y, Spot to) final;

    [[nodiscard]] SavedPaths save() const final;
    std::string load(const SavedPaths& memory) final;

    [[nodiscard]] const PathCounts& counts() const final { return counts_; }

    [[nodiscard]] std::size_t bytes() const override;

    /// Changes cells of the map. From now on all answers are those of the changed map. Paths that
    /// are cut, as far as their askers still have to go, are looked for anew (they wait again);
    /// so are those for which what was opened may be a short cut, who follow the old path until the
    /// new one is there, and those that could not get to their goal, where what they reach was
    /// joined with more, or a cell opened nearer to the goal. All others stay as they are. The
    /// index is renewed over the next ticks, and where to walk meanwhile in the next serve().
    void change(std::span<const CellChange> changes);

    /// Whether the index is that of the map as it is.
    [[nodiscard]] bool indexed() const { return indexed_; }

    [[nodiscard]] const GroundGrid& grid() const { return grid_; }

    [[nodiscard]] const GridPlanner& planner() const { return planner_; }

    /// Whether a path leads from the cell nearest to a place to another cell.
    bool reaches(Spot from, Cell to);

    /// How long the best path is from the cell nearest to a place to another cell, m; once the work
    /// of the tick is used up, about how long a path from area to area is. Nothing where none leads
    /// there.
    std::optional<float> length(Spot from, Cell to);

    [[nodiscard]] const RegionNextHop& regions() const { return regions_; }

  private:
    struct RequestSlot {
        std::uint32_t round = 0;
        std::uint32_t asker = 0;
        Spot at;  ///< where the asker was when last seen
        Spot to;
        Cell start;
        Cell goal;
        bool taken = false;
        bool waiting = false;
        bool usable = false;  ///< its corners lead somewhere
        bool moved = false;   ///< the goal stands for one in an obstacle
        bool best = false;
        bool doubted = false;  ///< it waits for another path if that pays
        PathOutcome outcome = PathOutcome::kUnreachable;
        CornerBlock corners;
        std::uint32_t next = 0;  ///< corner that the asker heads for
        float length_m = 0.0F;
        Spot ahead;           ///< that corner
        float rest_m = 0.0F;  ///< from there on
    };

    /// The map in kBlocks x kBlocks blocks, as bits: those that a path leads through or by, at
    /// least.
    static constexpr unsigned kBlocks = 32;
    using Blocks = std::array<std::uint64_t, kBlocks * kBlocks / 64>;

    /// Next steps from all cells to a goal that many ask for.
    struct CachedFlowField {
        Place goal = kNoPlace;
        std::uint64_t used = 0;
        std::vector<Hop> hops;
    };

    /// What a change opened: the middles of the cells, and the box that holds these.
    struct Gap {
        std::span<const Spot> middles;
        Spot low;
        Spot high;
    };

    /// What it closed: the cells, the box that holds these, and the blocks that it touches.
    struct Closed {
        std::span<const Cell> cells;
        FlowField::Window around;
        Blocks blocks;
    };

    static constexpr std::size_t kFields = 8;
    [[nodiscard]] SavedRequest saved_request(std::uint32_t number) const;
    void load(const SavedRequest& memory);
    /// What keeps it from being one of this map; empty: nothing.
    [[nodiscard]] std::string defect_of_memory(const SavedPaths& memory) const;
    /// Answers requests as far as the tick's work goes, and all that are due.
    void serve_waiting();
    /// So many requests are due in this tick still: what they need at least is kept for them.
    void keep_back(std::uint32_t due);
    /// Corners of the path are in `cells_`; false where the tick's work ended before it was found.
    bool find(RequestSlot& slot, bool cheaply);
    bool find_by_field(RequestSlot& slot);
    bool find_around_crowds(RequestSlot& slot);
    /// Whether a path around crowds is so much less than what is left of its own as to be taken.
    [[nodiscard]] bool pays(const RequestSlot& slot, std::uint64_t& work) const;
    bool find_by_planner(RequestSlot& slot);
    void find_by_regions(RequestSlot& slot);
    void prepare_table(Cell goal);
    /// Of the cells that stand for regions, and the start, the one nearest to the goal that is
    /// reached.
    Cell nearest_middle(const RequestSlot& slot);
    /// From the last of `cells_` to a goal in the same area.
    void walk_within_region(Cell goal);
    /// Makes a field, as far as the tick's work goes; true once it is there.
    bool make_field(Cell goal);
    /// On to the next cell.
    void append(Cell c, bool straight_on);
    /// Appends to `cells_` where hops lead.
    template <class HopAt>
    void walk(const HopAt& hop_at);
    void keep(std::uint32_t number);
    /// Takes the corners of a path away.
    void drop(std::uint32_t number);
    /// Those that the line between the middles of two cells leads through.
    void add_blocks(Blocks& blocks, Cell a, Cell b) const;
    void done(std::uint32_t number);
    void fail(std::uint32_t number, PathOutcome outcome);
    void wait(std::uint32_t number);
    /// Where those who wait and were not led so far may walk meanwhile, as far as the tick's work
    /// goes.
    void lead_waiting();
    /// Cells for where an asker is and wants to go; false where there are none.
    bool find_ends(std::uint32_t number);
    /// The ends of one who waited: it has walked on, and the map may have changed.
    bool refresh(std::uint32_t number);
    /// Fills opened_ and closed_; false where nothing changes.
    bool sort_changes(std::span<const CellChange> changes);
    [[nodiscard]] Gap gap() const;
    [[nodiscard]] Closed closed() const;
    /// What a change means for the path of a request.
    void review(std::uint32_t number, bool near, const Gap& gap, const Closed& closed);
    [[nodiscard]] bool cut(const RequestSlot& slot, const Closed& closed) const;
    [[nodiscard]] bool leads_through(Spot from, Spot to, const Closed& closed) const;
    [[nodiscard]] bool may_be_shorter(const RequestSlot& slot, const Gap& gap) const;
    [[nodiscard]] bool may_come_nearer(const RequestSlot& slot, const Gap& gap, Spot end) const;
    /// Puts those whom changes made wait in their queues.
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
    std::vector<Blocks> blocks_;  // by slot; none where there is no path
    unsigned block_shift_ = 0;    // of a cell's column or row
    std::vector<std::uint32_t> free_;
    std::vector<std::uint32_t> answered_;  // since the last serve()
    std::vector<std::uint32_t> told_;      // by it
    std::vector<std::uint32_t> requeued_;
    std::vector<std::uint32_t> to_queue_;  // that wait since a change, in no queue yet
    std::vector<std::uint32_t> unled_;     // that wait since a change
    std::vector<Spot> opened_;             // middles of the cells of a change
    std::vector<Cell> closed_;             // of it
    std::vector<std::uint32_t> near_;  // slots that it may concern, doubled; odd: by what it closed
    std::unique_ptr<pathfinding::CrowdPaths> crowd_;  // null: crowds are no matter
    std::vector<std::uint32_t> doubted_;
    std::size_t next_review_ = 0;        // slot
    std::uint64_t reviewed_round_ = 0;   // of the crowds
    std::vector<std::uint32_t> wanted_;  // by place: requests for it that wait
    std::array<CachedFlowField, kFields> fields_;
    FlowField builder_;
    Place building_ = kNoPlace;
    std::uint64_t typical_work_ = 0;  // of a path by the planner
    std::uint64_t cheap_work_ = 0;    // of one from area to area
    std::uint64_t budget_ = 0;        // of the tick, but for what is kept back
    bool searched_ = false;           // in this tick
    std::vector<Cell> cells_;
    FlowField near_goal_;
    std::uint32_t next_table_ = 0;  // of regions, to be made
    bool indexed_ = true;
    std::uint64_t spent_ = 0;
    std::uint64_t tick_ = 0;
    PathCounts counts_;
};

}  // namespace zoned::ai::pathfinding
