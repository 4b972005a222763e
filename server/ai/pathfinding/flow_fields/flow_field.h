// FlowField: from every cell the next step towards one goal, and how far it is.
#pragma once

#include "server/ai/pathfinding/grid/cost.h"
#include "server/ai/pathfinding/grid/grid_map.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace zoned::ai::pathfinding {

/// Number of a step to a neighbour, 0 to 7: those along rows and columns first.
using Hop = std::uint8_t;

inline constexpr Hop kArrived = 8;  ///< at the goal
inline constexpr Hop kNoHop = 9;    ///< blocked, or no path

/// Opposite steps differ in their last bit.
inline constexpr std::array<int, 10> kHopX{1, -1, 0, 0, 1, -1, 1, -1, 0, 0};
inline constexpr std::array<int, 10> kHopY{0, 0, 1, -1, 1, -1, -1, 1, 0, 0};

/// The neighbour of `c` in that direction; `c` itself for kArrived and kNoHop.
inline Cell hopped(Cell c, Hop hop) {
    return {static_cast<std::uint16_t>(c.x + kHopX[hop]),
            static_cast<std::uint16_t>(c.y + kHopY[hop])};
}

/// A field for crowds that share a goal: looked up in place of planning, cell by cell.
class FlowField {
  public:
    /// Best paths from all cells to `goal`, which is on the map. Dijkstra in linear time: no step
    /// costs less than kStraight, so that cells whose costs lie within kStraight of each other,
    /// from a multiple of it on, may be settled in any order (Denardo and Fox, "Shortest-route
    /// methods: 1. Reaching, pruning, and buckets", Operations Research 27, 1979), and of paths of
    /// the same cost only those are followed that have their diagonal steps first (Sturtevant and
    /// Rabin, "Canonical orderings on grids", IJCAI 2016): most cells are reached once. Allocates
    /// nothing where the map is no larger than the last one. A blocked goal is reached from
    /// nowhere.
    void build(const GridMap& map, Cell goal);

    /// As build(), in resumable_task: begin(), then advance() until it says that the field is
    /// there. The map stays as it is meanwhile.
    void begin(const GridMap& map, Cell goal);

    /// Spreads from so many cells at most. True: the field is there.
    bool advance(const GridMap& map, std::uint32_t cells);

    /// Cells of a rectangle, its last column and row among them.
    struct Window {
        int left;
        int top;
        int right;
        int bottom;
    };

    /// As above by paths within a rectangle, in which the goal lies; only what lies in it may be
    /// asked for afterwards.
    void build(const GridMap& map, Cell goal, const Window& window);

    /// As above to the nearest of several passable goals in the rectangle, none twice.
    void build(const GridMap& map, std::span<const Cell> goals, const Window& window);

    [[nodiscard]] Hop hop(Place p) const { return hop_[p]; }

    /// Of a best path to the goal; kNoCost where there is none.
    [[nodiscard]] Cost cost(Place p) const { return cost_[p]; }

    /// Of the best paths to the goal the longest.
    [[nodiscard]] Cost longest() const { return longest_; }

    /// All hops, by place.
    void copy_hops(std::vector<Hop>& hops) const { hops.assign(hop_.begin(), hop_.end()); }

    [[nodiscard]] std::size_t bytes() const;

  private:
    /// PointsOfInterest whose costs lie between two multiples of kStraight, each once; and such as
    /// have got cheaper since, which are in an earlier bucket too. Only `size` of them count: the
    /// rest is room.
    struct Bucket {
        std::vector<Place> places;
        std::size_t size = 0;
    };

    /// A diagonal step leads into the bucket after the next one at most.
    static constexpr std::size_t kBuckets = 3;

    /// For a field that reaches so many cells at most.
    void make_room(const GridMap& map, std::size_t reached);
    void close_window(const GridMap& map, const Window& window);
    void start(const GridMap& map, std::span<const Cell> goals);
    /// Settles `count` places of the first bucket.
    void spread(const GridMap& map, std::size_t count);

    std::vector<Cost> cost_;
    std::vector<Hop> hop_;
    std::array<Bucket, kBuckets> buckets_;  // that of first_cost_, and the ones after it
    Cost first_cost_ = 0;                   // of the first bucket, at least
    std::size_t next_ = 0;                  // in it
    Cost longest_ = 0;
};

}  // namespace zoned::ai::pathfinding
