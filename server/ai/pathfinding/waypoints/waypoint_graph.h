// WaypointGraph: a graph of hand-placed or regular waypoints, with its text form.
#pragma once

#include "server/ai/pathfinding/grid/grid_query.h"
#include "server/ai/pathfinding/grid/search_heap.h"
#include "shared/core/result.h"
#include "shared/math/types.h"

#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>
#include <vector>

namespace zoned::ai::pathfinding {

struct Waypoint {
    std::uint32_t id = 0;          ///< unique, any number
    Vec3 position = Vec3::Zero();  ///< m, finite
    bool passable = true;
};

/// A directed edge from a waypoint to another.
struct WaypointEdge {
    std::uint32_t from = 0;  ///< id
    std::uint32_t to = 0;
    float weight = 0.0F;  ///< cost of the edge: >= 0, e.g. its length
};

/// Waypoints by number (0, 1, ... in the order given) with the edges out of each.
class WaypointGraph {
  public:
    static constexpr std::size_t kMostWaypoints = 1'000'000;
    static constexpr std::size_t kMostEdges = 8'000'000;

    /// Builds a graph. Errors: an id given twice or unknown, a weight below 0 or not a number, an
    /// invalid position, too many waypoints or edges.
    static core::Result<WaypointGraph> build(std::span<const Waypoint> waypoints,
                                             std::span<const WaypointEdge> edges);

    [[nodiscard]] std::uint32_t size() const { return static_cast<std::uint32_t>(ids_.size()); }

    /// The number of an id; size() for an unknown id.
    [[nodiscard]] std::uint32_t number_of(std::uint32_t id) const;

    [[nodiscard]] std::uint32_t id(std::uint32_t number) const { return ids_[number]; }

    [[nodiscard]] const Vec3& position(std::uint32_t number) const { return positions_[number]; }

    [[nodiscard]] bool passable(std::uint32_t number) const { return passable_[number] != 0; }

    /// Sets a waypoint that a door opens or shuts; the next answer is exact again.
    void set_passable(std::uint32_t number, bool passable) { passable_[number] = passable ? 1 : 0; }

    /// Gives this weight, >= 0, to all edges from a waypoint to another; false where there is none.
    bool set_weight(std::uint32_t from, std::uint32_t to, float weight);

    /// The passable waypoint nearest to a place, ties to the smaller number; size() for none. It
    /// looks at waypoints with near x first. A place whose height is not a number is at any height.
    [[nodiscard]] std::uint32_t nearest(const Vec3& place) const;

    struct Edge {
        std::uint32_t to;
        float weight;
        bool open = true;  ///< the edge is passable
    };

    /// Edges are numbered, those of a waypoint one after the other.
    [[nodiscard]] std::uint32_t first_edge(std::uint32_t number) const {
        return first_edge_[number];
    }

    [[nodiscard]] std::uint32_t edge_count() const {
        return static_cast<std::uint32_t>(edges_.size());
    }

    [[nodiscard]] const Edge& edge(std::uint32_t edge) const { return edges_[edge]; }

    void set_open(std::uint32_t edge, bool open) { edges_[edge].open = open; }

    /// The same graph with `origin` subtracted from all places: in the coordinates of a zone.
    [[nodiscard]] WaypointGraph seen_from(const Vec3d& origin) const;

    [[nodiscard]] std::span<const Edge> edges(std::uint32_t number) const {
        return {edges_.data() + first_edge_[number], edges_.data() + first_edge_[number + 1]};
    }

    /// No edge costs less than this times its length. So this times the distance to a goal is a
    /// lower bound of a path's cost.
    [[nodiscard]] double least_weight_per_m() const { return least_per_m_; }

    [[nodiscard]] std::size_t bytes() const {
        return positions_.capacity() * sizeof(Vec3) + passable_.capacity() +
               edges_.capacity() * sizeof(Edge) +
               (ids_.capacity() + first_edge_.capacity() + by_id_.capacity() + by_x_.capacity()) *
                   sizeof(std::uint32_t);
    }

  private:
    void sort_by_x();
    void lower_least(std::uint32_t from, const Edge& edge);

    std::vector<std::uint32_t> ids_;
    std::vector<Vec3> positions_;
    std::vector<std::uint8_t> passable_;
    std::vector<std::uint32_t> first_edge_;  // by number, and one more
    std::vector<Edge> edges_;
    std::vector<std::uint32_t> by_id_;  // numbers
    std::vector<std::uint32_t> by_x_;
    double least_per_m_ = 0.0;
};

/// Parses lines `node ID X Y Z [blocked]` and `edge FROM TO WEIGHT [both]` in any order (an edge
/// may come before its nodes). WEIGHT is a number or `length`. Empty lines and text after a # are
/// skipped. An error names its line.
core::Result<WaypointGraph> parse_waypoints(std::string_view text);

/// WaypointSearch: searches paths on a graph. It has memory for one query at a time, and allocates
/// nothing after the first.
class WaypointSearch {
  public:
    struct WaypointAnswer {
        PathOutcome outcome = PathOutcome::kUnreachable;  ///< kOffMap: there is no such waypoint
        double cost = 0.0;                                ///< sum of the weights along the path
        std::uint32_t work = 0;                           ///< waypoints looked at
    };

    /// A* with the distance to the goal times least_weight_per_m(): exact. Ties go by number.
    /// Source: Hart, Nilsson and Raphael, IEEE Transactions on Systems Science and Cybernetics 4,
    /// 1968.
    WaypointAnswer plan(const WaypointGraph& graph,
                        std::uint32_t start,
                        std::uint32_t goal,
                        std::uint32_t max_work = ~0U);

    /// A waypoint at which a path may begin or end, and the cost of coming there.
    struct WaypointEnd {
        std::uint32_t number;
        double cost;
    };

    /// The best path from any of some waypoints to any of others, by Dijkstra. The costs of coming
    /// to the ends count. Ends must be passable.
    WaypointAnswer plan(const WaypointGraph& graph,
                        std::span<const WaypointEnd> starts,
                        std::span<const WaypointEnd> ends);

    /// The last found path: numbers from start to goal.
    [[nodiscard]] std::span<const std::uint32_t> path() const { return path_; }

    [[nodiscard]] std::size_t bytes() const {
        return known_.capacity() * sizeof(KnownWaypoint) + open_.bytes() +
               path_.capacity() * sizeof(std::uint32_t);
    }

  private:
    struct KnownWaypoint {
        double cost = 0.0;
        std::uint32_t from = 0;
        std::uint32_t search = 0;
    };

    struct OpenWaypoint {
        double key;  ///< estimate of the whole path
        std::uint32_t node;
        double cost;
    };

    void begin(const WaypointGraph& graph);
    void reach(std::uint32_t number, double cost, std::uint32_t from, double ahead);
    void trace(std::uint32_t last);

    std::vector<KnownWaypoint> known_;
    SearchHeap<OpenWaypoint> open_;
    std::vector<std::uint32_t> path_;
    std::uint32_t search_ = 0;
};

}  // namespace zoned::ai::pathfinding
