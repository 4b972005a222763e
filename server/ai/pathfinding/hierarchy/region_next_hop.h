// RegionNextHop: the next hop from anywhere to anywhere, by two look-ups.
#pragma once

#include "server/ai/pathfinding/flow_fields/flow_field.h"
#include "server/ai/pathfinding/grid/open_list.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace zoned::ai::pathfinding {

/// The map is cut into squares. Cells of a square that reach each other within it are an region; it
/// has an exit to each region beyond the square's sides that it touches. Each cell knows the next
/// step to each exit of its region, and how far that is; each region learns how far it is to a
/// goal's region when somebody asks for one there (routes over coarse regions, as in Sturtevant,
/// "Memory- efficient abstractions for pathfinding", AIIDE 2007). So who has no path yet can set
/// out at once.
///
/// Hops lead to the goal, not by a best path: on, each exit leads nearer to it, region by region,
/// and each step nearer to an exit.
class RegionNextHop {
  public:
    explicit RegionNextHop(const GridMap& map);

    /// After `changes` were made to the map: forgets which regions lie how far from which. Nothing
    /// else may be asked until settle() has renewed the squares that they touch.
    void note(std::span<const CellChange> changes);

    [[nodiscard]] bool settled() const { return stale_.empty(); }

    /// Renews what was noted, for the map as it is. Units of some 2 ns that it took.
    std::uint64_t settle(const GridMap& map);

    void update(const GridMap& map, std::span<const CellChange> changes) {
        note(changes);
        settle(map);
    }

    /// Makes the table for goals in the region of `to`, a passable cell, unless it is there. hop()
    /// is then const, for any number of threads.
    void prepare(const GridMap& map, Cell to);

    /// The table of one region, 0 to regions() - 1, unless it is there.
    void prepare(std::uint32_t region) { measure(region); }

    [[nodiscard]] bool prepared(const GridMap& map, Cell to) const {
        return settled() && !far_[region_of(map, to)].empty();
    }

    [[nodiscard]] bool prepared(std::uint32_t region) const { return !far_[region].empty(); }

    /// A cell of each region that has a table.
    [[nodiscard]] std::vector<Cell> prepared() const;

    void forget_tables();

    /// Whether both lie in one region: hop() then knows no more.
    [[nodiscard]] bool together(const GridMap& map, Cell a, Cell b) const {
        return region_of(map, a) == region_of(map, b);
    }

    /// Both passable, `to` prepared. kArrived where both lie in one region, kNoHop where there is
    /// no path.
    [[nodiscard]] Hop hop(const GridMap& map, Cell from, Cell to) const;

    /// About how far it is by hops, in cells; both passable, joined, `to` prepared.
    [[nodiscard]] std::uint32_t cells(const GridMap& map, Cell from, Cell to) const;

    /// Calls `visit(cell, hop)` for each cell that hops lead to from `from`, and the hop there,
    /// until it says false or the goal's region is entered. Each region is left by the exit that is
    /// best from where it is entered. False where there is no path.
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

    [[nodiscard]] std::size_t regions() const { return far_.size(); }

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
    using Step = std::uint16_t;  ///< a hop in its low four bits, above them how far, in cells

    static constexpr unsigned kHopBits = 4;
    static constexpr unsigned kHopMask = 15;

    struct Exit {
        std::uint16_t region;  ///< of the square
        std::uint16_t other;   ///< of the square beyond
        std::uint32_t square;  ///< beyond
        std::uint32_t first;   ///< of its steps, which cover the region's box
        std::uint32_t cells;   ///< to it from the cell that stands for the region
    };

    /// The box of an region, and the cell in it that stands for the region.
    struct RegionBox {
        std::uint16_t left, top, width, height;
        Cell middle;
    };

    struct Square {
        std::vector<RegionBox> boxes;           // of its regions
        std::vector<Exit> exits;                // ascending by region
        std::vector<std::uint32_t> first_exit;  // by region, and one more
        std::vector<Step> steps;
    };

    /// From an region to one beside it.
    struct RegionEdge {
        std::uint32_t to;
        std::uint32_t cells;
    };

    /// A cell next to another region, and the number of that in its square.
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
        return square.steps[exit.first + static_cast<std::uint32_t>(c.y - box.top) * box.width +
                            static_cast<std::uint32_t>(c.x - box.left)];
    }

    /// Of the labels along its sides, in the order of hops.
    [[nodiscard]] std::array<std::uint64_t, 4> sides_of(const GridMap& map,
                                                        std::uint32_t square) const;
    [[nodiscard]] FlowField::Window window_of(const GridMap& map, std::uint32_t square) const;
    void note_square(std::uint32_t square, std::uint32_t sides);
    void find_regions(const GridMap& map, std::uint32_t square);
    RegionBox fill_region(const GridMap& map,
                          const FlowField::Window& w,
                          Cell first,
                          std::uint16_t label);
    /// By the sides whose bits are set; other exits stay as they are, `square`'s regions too.
    void find_exits(const GridMap& map, std::uint32_t square, std::uint32_t sides);
    void add_exits(const GridMap& map, std::uint32_t square, std::uint16_t region, Hop side);
    void add_exit(const GridMap& map, std::uint32_t square, const Exit& exit, Hop across);
    void keep_exits(std::uint32_t square, std::uint16_t region, std::uint32_t beyond);
    /// Of a square: the one beyond a side; itself where that is off the map.
    [[nodiscard]] std::uint32_t beside(std::uint32_t square, Hop side) const;
    void join_regions_of_squares();
    /// Of those of an region by which a cell of it comes nearer to a goal's region; null for none.
    [[nodiscard]] const Exit* best_exit(const Square& square,
                                        std::uint32_t region,
                                        std::uint32_t goal,
                                        Cell from) const;
    void measure(std::uint32_t goal);

    int side_;
    int across_;
    int down_;
    std::vector<Square> squares_;
    std::vector<std::uint16_t> label_;         // by place: number in its square + 1; 0 for blocked
    std::vector<std::uint32_t> first_region_;  // by square, and one more
    std::vector<std::uint32_t> first_edge_;    // by region, and one more
    std::vector<RegionEdge> edges_;
    std::vector<std::vector<std::uint16_t>> far_;  // by goal's region: by region how many cells
    OpenList open_;                                // regions
    std::vector<std::uint32_t> cells_to_;          // by region, of the search that goes on
    FlowField field_;
    std::vector<Cell> stack_;
    std::vector<Cell> crossings_;
    std::vector<Crossing> touched_;
    std::vector<std::uint8_t> stale_sides_;  // by square: bits of sides, during an update
    std::vector<std::uint32_t> stale_;       // squares
    std::uint64_t units_ = 0;                // of the settle() that goes on
    Square old_;                             // whose exits are found anew
};

}  // namespace zoned::ai::pathfinding
