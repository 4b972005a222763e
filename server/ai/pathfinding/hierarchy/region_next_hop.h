// RegionNextHop: looks up the next hop from any cell to any goal in two tables.
#pragma once

#include "server/ai/pathfinding/flow_fields/flow_field.h"
#include "server/ai/pathfinding/grid/open_list.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace zoned::ai::pathfinding {

/// The map is cut into squares. Cells of a square that reach each other within it are a region. A
/// region has an exit to each region beyond the square's sides that it touches. Each cell stores
/// the next step to each exit of its region, and the distance. The distances of all regions to a
/// goal's region are computed when a goal there is first requested. So an agent without a path can
/// set out at once. The tables of the last goals' regions are kept. Source for routes over
/// coarse regions: Sturtevant, "Memory-efficient abstractions for pathfinding", AIIDE 2007.
///
/// Hops lead to the goal, but not by a best path. Each exit leads nearer to the goal, region by
/// region, and each step nearer to an exit.
class RegionNextHop {
  public:
    /// Tables that are kept; more are kept only while all are needed.
    static constexpr std::size_t kTables = 512;

    explicit RegionNextHop(const GridMap& map, std::size_t most_tables = kTables);

    /// Call after `changes` to the map: drops the distances between regions. Nothing else may be
    /// called until settle() has renewed the squares that the changes touch.
    void note(std::span<const CellChange> changes);

    [[nodiscard]] bool settled() const { return stale_.empty(); }

    /// Renews the noted squares, for the map as it is. Returns the work in units of some 2 ns.
    std::uint64_t settle(const GridMap& map);

    void update(const GridMap& map, std::span<const CellChange> changes) {
        note(changes);
        settle(map);
    }

    /// TableUse: the tick of a use. Tables that were used since `needed_since` are not replaced.
    struct TableUse {
        std::uint64_t now = 0;
        std::uint64_t needed_since = 0;
    };

    /// Makes the table for goals in the region of `to`, a passable cell, unless it exists; true
    /// where it was made. It replaces the one that was used longest ago where there are as many as
    /// are kept.
    /// hop() is then const, for any number of threads.
    bool prepare(const GridMap& map, Cell to, const TableUse& use);

    bool prepare(const GridMap& map, Cell to) { return prepare(map, to, {0, 0}); }

    /// True if some region has no table, and all tables together may be kept.
    [[nodiscard]] bool lacks_tables() const {
        return settled() && used_tables_ < regions() && regions() <= most_tables_;
    }

    /// Makes the table of the first region that has none.
    void prepare_next(std::uint64_t now);

    [[nodiscard]] bool prepared(const GridMap& map, Cell to) const {
        return settled() && table_of_[region_of(map, to)] != kNoTable;
    }

    void forget_tables();

    /// Calls `visit(cell, used)` for a cell of each region that has a table, ascending by region.
    template <class Visit>
    void visit_tables(const Visit& visit) const {
        std::uint32_t region = 0;
        visit_middles([&](Cell middle) {
            const std::uint32_t table = table_of_[region++];
            if (table != kNoTable) {
                visit(middle, tables_[table].used);
            }
        });
    }

    /// True if both lie in one region: hop() then has no answer.
    [[nodiscard]] bool together(const GridMap& map, Cell a, Cell b) const {
        return region_of(map, a) == region_of(map, b);
    }

    /// The hop from `from` towards `to`. Both must be passable, and `to` prepared. kArrived where
    /// both lie in one region, kNoHop where there is no path.
    [[nodiscard]] Hop hop(const GridMap& map, Cell from, Cell to) const;

    /// The approximate distance by hops, in cells. Both must be passable and joined, and `to`
    /// prepared.
    [[nodiscard]] std::uint32_t cells(const GridMap& map, Cell from, Cell to) const;

    /// Calls `visit(cell, hop)` for each cell that hops lead to from `from`, with the hop there. It
    /// ends when visit returns false or the goal's region is entered. Each region is left by the
    /// exit that is best from its entry. False where there is no path.
    template <class Visit>
    bool lead(const GridMap& map, Cell from, Cell to, const Visit& visit) const {
        const std::uint32_t goal = region_of(map, to);
        for (std::uint32_t region = region_of(map, from); region != goal;) {
            const Square& square = squares_[square_of(from)];
            const Exit* const exit = best_exit(square, region, goal, from);
            if (exit == nullptr) {
                return false;
            }
            bool out = false;
            while (!out) {
                const Step there = step(square, *exit, from);
                const Hop hop = there & kHopMask;
                out = there >> kHopBits == 0;
                from = hopped(from, hop);
                if (!visit(from, hop)) {
                    return true;
                }
            }
            region = first_region_[exit->square] + exit->other;
        }
        return true;
    }

    [[nodiscard]] std::size_t regions() const { return first_region_.back(); }

    /// Calls `visit(cell)` for a cell of each region.
    template <class Visit>
    void visit_middles(const Visit& visit) const {
        for (const Square& s : squares_) {
            for (const RegionBox& box : s.boxes) {
                visit(box.middle);
            }
        }
    }

    /// Cells of a square's side.
    [[nodiscard]] int side() const { return side_; }

    /// The square of a cell.
    [[nodiscard]] FlowField::Window window(const GridMap& map, Cell c) const {
        return window_of(map, square_of(c));
    }

    [[nodiscard]] std::size_t bytes() const;

  private:
    using Step = std::uint16_t;  ///< a hop in its low four bits, the distance in cells above them

    static constexpr std::uint32_t kNoTable = ~0U;
    static constexpr unsigned kHopBits = 4;
    static constexpr unsigned kHopMask = 15;

    /// Distances in cells to a region, by region.
    struct Table {
        std::uint32_t goal = 0;
        std::uint64_t used = 0;
        std::vector<std::uint16_t> far;
    };

    struct Exit {
        std::uint16_t region;  ///< number in the square
        std::uint16_t other;   ///< number in the square beyond
        std::uint32_t square;  ///< the square beyond
        std::uint32_t first;   ///< index of the first of its steps, which cover the region's box
        bool open;             ///< its steps are in open_steps_
        std::uint32_t cells;   ///< distance to it from the cell that stands for the region
    };

    /// The box of a region, and the cell in it that stands for the region.
    struct RegionBox {
        std::uint16_t left, top, width, height;
        Cell middle;
        bool whole;  ///< all of the box
    };

    /// The steps of an exit that is all of a side, from a region that is all of its box. Most of
    /// the squares in open country have these, so they share them.
    struct OpenExit {
        std::uint16_t width, height;
        Hop side;
        std::uint32_t first;  ///< index of the first of them in open_steps_
    };

    struct Square {
        std::vector<RegionBox> boxes;           // of the square's regions
        std::vector<Exit> exits;                // ascending by region
        std::vector<std::uint32_t> first_exit;  // by region, and one more
        std::vector<Step> steps;
        bool open = false;  // all of it is passable
    };

    /// From a region to an adjacent one.
    struct RegionEdge {
        std::uint32_t to;
        std::uint32_t cells;
    };

    /// A cell next to another region, and that region's number in its square.
    struct Crossing {
        std::uint16_t other;
        Cell cell;
    };

    [[nodiscard]] std::uint32_t square_of(Cell c) const {
        return static_cast<std::uint32_t>(c.y / side_ * across_ + c.x / side_);
    }

    [[nodiscard]] std::uint32_t region_of(const GridMap& map, Cell c) const {
        return first_region_[square_of(c)] + label_[map.place(c)] - 1U;
    }

    [[nodiscard]] Step step(const Square& square, const Exit& exit, Cell c) const {
        const RegionBox& box = square.boxes[exit.region];
        const std::vector<Step>& steps = exit.open ? open_steps_ : square.steps;
        return steps[exit.first + static_cast<std::uint32_t>(c.y - box.top) * box.width +
                     static_cast<std::uint32_t>(c.x - box.left)];
    }

    /// The labels along a square's sides, in the order of hops.
    [[nodiscard]] std::array<std::uint64_t, 4> sides_of(const GridMap& map,
                                                        std::uint32_t square) const;
    [[nodiscard]] FlowField::Window window_of(const GridMap& map, std::uint32_t square) const;
    void note_square(std::uint32_t square, std::uint32_t sides);
    void find_regions(const GridMap& map, std::uint32_t square);
    /// True if all cells of a window are passable.
    static bool is_open(const GridMap& map, const FlowField::Window& w);
    static RegionBox box_of(const FlowField::Window& w);
    RegionBox fill_region(const GridMap& map,
                          const FlowField::Window& w,
                          Cell first,
                          std::uint16_t label);
    /// Finds the exits at the sides whose bits are set; other exits and the regions of `square`
    /// stay as they are.
    void find_exits(const GridMap& map, std::uint32_t square, std::uint32_t sides);
    void add_exits(const GridMap& map, std::uint32_t square, std::uint16_t region, Hop side);
    void add_exit(const GridMap& map, std::uint32_t square, const Exit& exit, Hop across);
    [[nodiscard]] std::uint32_t open_exit(const GridMap& map, const RegionBox& box, Hop across);
    void append_steps(const GridMap& map,
                      const RegionBox& box,
                      std::uint16_t region,
                      Hop across,
                      std::vector<Step>& steps);
    void keep_exits(std::uint32_t square, std::uint16_t region, std::uint32_t beyond);
    /// The square beyond a side of a square; the square itself where that is off the map.
    [[nodiscard]] std::uint32_t beside(std::uint32_t square, Hop side) const;
    void join_regions_of_squares();
    /// The exit of a region by which a cell of it comes nearer to a goal's region; null for none.
    [[nodiscard]] const Exit* best_exit(const Square& square,
                                        std::uint32_t region,
                                        std::uint32_t goal,
                                        Cell from) const;
    void make_table(std::uint32_t goal, const TableUse& use);
    void measure(std::uint32_t goal);
    /// The table to be filled: a new one, or the one that was used longest ago.
    std::uint32_t free_table(std::uint64_t needed_since);
    std::size_t most_tables_;
    int side_;
    int across_;
    int down_;
    std::vector<Square> squares_;
    std::vector<std::uint16_t> label_;         // by place: number in its square + 1; 0 for blocked
    std::vector<std::uint32_t> first_region_;  // by square, and one more
    std::vector<std::uint32_t> first_edge_;    // by region, and one more
    std::vector<RegionEdge> edges_;
    std::vector<Table> tables_;  // the first used_tables_ count, the rest is room
    std::size_t used_tables_ = 0;
    std::vector<std::uint32_t> table_of_;  // by goal's region
    std::vector<OpenExit> open_exits_;
    std::vector<Step> open_steps_;
    OpenList open_;                        // regions
    std::vector<std::uint32_t> cells_to_;  // by region, distance in the present search
    FlowField field_;
    std::vector<Cell> stack_;
    std::vector<Cell> crossings_;
    std::vector<Crossing> touched_;
    std::vector<std::uint8_t> stale_sides_;  // by square: bits of sides, during an update
    std::vector<std::uint32_t> stale_;       // squares
    std::uint64_t units_ = 0;                // work of the present settle()
    Square old_;                             // the square whose exits are found anew
};

}  // namespace zoned::ai::pathfinding
