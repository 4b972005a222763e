// FlowField: the next step from every cell towards one goal, and the cost of the path.
#pragma once

#include "server/ai/pathfinding/grid/cost.h"
#include "server/ai/pathfinding/grid/grid_map.h"
#include "shared/core/containers/zero_pages.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace zoned::ai::pathfinding {

/// The number of a step to a neighbour, 0 to 7: steps along rows and columns first.
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

/// A field for crowds that share a goal. It is looked up cell by cell instead of planning.
class FlowField {
  public:
    /// Finds best paths from all cells to `goal`, which is on the map. It is Dijkstra's method in
    /// linear time. No step costs less than kStraight. So cells whose costs lie within kStraight of
    /// each other, from a multiple of it on, may be settled in any order. Source: Denardo and Fox,
    /// "Shortest-route methods: 1. Reaching, pruning, and buckets", Operations Research 27, 1979.
    /// Of paths of the same cost only those with their diagonal steps first are followed, so most
    /// cells are reached once. Source: Sturtevant and Rabin, "Canonical orderings on grids", IJCAI
    /// 2016. Allocates nothing where the map is no larger than the last one. A blocked goal is
    /// reached from nowhere.
    void build(const GridMap& map, Cell goal);

    /// As build(), in parts: begin(), then advance() until it returns true. The map must stay
    /// unchanged meanwhile.
    void begin(const GridMap& map, Cell goal);

    /// Spreads from at most so many cells. True: the field is complete.
    bool advance(const GridMap& map, std::uint32_t cells);

    /// A rectangle of cells; its last column and row belong to it.
    struct Window {
        int left;
        int top;
        int right;
        int bottom;
    };

    /// As above by paths within a rectangle that contains the goal; afterwards only cells in it may
    /// be asked for.
    void build(const GridMap& map, Cell goal, const Window& window);

    /// As above to the nearest of several passable goals in the rectangle, none twice.
    void build(const GridMap& map, std::span<const Cell> goals, const Window& window);

    [[nodiscard]] Hop hop(Place p) const { return hop_[p]; }

    /// The cost of a best path to the goal; kNoCost where there is none.
    [[nodiscard]] Cost cost(Place p) const { return cost_[p]; }

    /// The cost of the longest of the best paths to the goal.
    [[nodiscard]] Cost longest() const { return longest_; }

    /// All hops, by place.
    void copy_hops(std::vector<Hop>& hops) const {
        hops.assign(hop_.all().begin(), hop_.all().end());
    }

    [[nodiscard]] std::size_t bytes() const;

  private:
    /// The places whose costs lie between two multiples of kStraight, each once. It also holds
    /// places that have become cheaper since and are in an earlier bucket too. Only the first
    /// `size` entries count; the rest is room.
    struct Bucket {
        core::ZeroPages<Place> places;
        std::size_t size = 0;
    };

    /// A diagonal step leads at most into the bucket after the next one.
    static constexpr std::size_t kBuckets = 3;

    /// Makes room for a field that reaches at most so many cells.
    void make_room(const GridMap& map, std::size_t reached);
    void close_window(const GridMap& map, const Window& window);
    void start(const GridMap& map, std::span<const Cell> goals);
    /// Settles `count` places of the first bucket.
    void spread(const GridMap& map, std::size_t count);

    core::ZeroPages<Cost> cost_;
    core::ZeroPages<Hop> hop_;
    std::array<Bucket, kBuckets> buckets_;  // the bucket of first_cost_, and the ones after it
    Cost first_cost_ = 0;                   // lower bound of the first bucket
    std::size_t next_ = 0;                  // index in the first bucket
    Cost longest_ = 0;
};

}  // namespace zoned::ai::pathfinding
