// WaypointPaths: finds paths along waypoints, with doors that turn.
#pragma once

#include "server/ai/pathfinding/hierarchy/graph_hierarchy.h"
#include "server/ai/pathfinding/requests/path_request_queue.h"
#include "server/ai/pathfinding/waypoints/waypoint_doors.h"
#include "server/ai/pathfinding/waypoints/waypoint_graph.h"
#include "shared/math/aabb.h"

#include <utility>
#include <vector>

namespace zoned::ai::pathfinding {

struct WaypointPathsSettings {
    QueueSettings queue;
    /// The most waypoints that one search may look at; beyond, the path goes from group to group.
    std::uint32_t search_work = 20'000;
};

/// The path leads from the waypoint nearest to the start to the one nearest to the goal, by the
/// least sum of weights. Then it leads to the goal itself. Where both waypoints are the same it
/// leads straight to the goal. An agent on the path's first edge does not go back to its beginning.
/// It does not go beyond a goal on the last edge either. If the goal's waypoint cannot be reached,
/// the path leads to the nearest reachable one (kPartial). The author of the waypoints has to make
/// sure that a walker can reach the waypoint nearest to any place.
class WaypointPaths final : public PathRequestQueue {
  public:
    /// `doors` are the result of waypoint_doors() for the graph; `shut` is by door.
    WaypointPaths(WaypointGraph graph,
                  std::vector<WaypointDoor> doors,
                  std::span<const std::uint8_t> shut,
                  const WaypointPathsSettings& settings = {});

    void turn_doors(std::span<const std::uint8_t> shut) override;
    [[nodiscard]] bool straight(Spot from, float from_y, Spot to, float to_y) const override;

    /// True: any place has a nearest waypoint.
    [[nodiscard]] bool contains(Spot place) const override;

    MapExit straight_exit(Spot /*from*/, float /*from_y*/, Spot to) override { return {to}; }

    [[nodiscard]] std::size_t bytes() const override;

    [[nodiscard]] const WaypointGraph& waypoints() const { return graph_; }

  protected:
    PathOutcome locate(PathRequestEntry& request) override;
    void find(const PathRequestEntry& request, bool late, FoundPath& found) override;
    Spot first_segment(PathRequestEntry& request, Spot at) const override;
    void prepare_segments(const PathRequestEntry& request) override;
    [[nodiscard]] MapNumbers numbers() const override;

    [[nodiscard]] std::vector<std::uint32_t> tables() const override {
        return clusters_.prepared();
    }

    void make_table(std::uint32_t node) override { clusters_.prepare(node); }

    [[nodiscard]] bool passable(const Hinge& hinge) const override;
    [[nodiscard]] bool may_be_shorter(const PathRequestEntry& request) const override;
    [[nodiscard]] bool may_come_nearer(const PathRequestEntry& request) const override;

  private:
    /// A waypoint or edge that depends on doors, and the number of these that are shut.
    struct Hung {
        std::uint32_t what = 0;
        bool bridge = false;  ///< some door gives it
        bool placed = true;   ///< a waypoint that is passable by itself
        std::uint16_t takers = 0;
        std::uint16_t givers = 0;

        [[nodiscard]] bool open() const { return placed && takers == 0 && (!bridge || givers > 0); }
    };

    [[nodiscard]] NodeGraph graph() const;
    void hang(const std::vector<WaypointDoor>& doors);
    bool follow(std::span<const std::uint8_t> shut);
    [[nodiscard]] bool is_open(std::uint32_t what) const;
    /// The two ends of a waypoint or edge.
    [[nodiscard]] std::pair<Vec3, Vec3> ends_of(std::uint32_t what) const;
    /// The waypoint that an edge leads from.
    [[nodiscard]] std::uint32_t start_of(std::uint32_t edge) const;
    void ready(std::uint32_t goal);
    bool find_by_clusters(std::uint32_t from, std::uint32_t goal);
    std::uint32_t nearest_reached(const PathRequestEntry& request);
    void take(const PathRequestEntry& request, bool to_goal, FoundPath& found) const;
    [[nodiscard]] std::uint32_t edge_between(std::uint32_t from, std::uint32_t to) const;
    /// True if a place lies beside an edge, not before its beginning.
    [[nodiscard]] bool on_edge(const Vec3& place, std::uint32_t from, std::uint32_t to) const;

    WaypointPathsSettings settings_;
    WaypointGraph graph_;
    WaypointSearch search_;
    GraphHierarchy clusters_;
    std::vector<Vec3> places_;
    std::vector<std::uint32_t> first_;
    std::vector<std::uint32_t> to_;
    std::vector<std::uint32_t> return_;
    std::vector<std::uint8_t> open_;                 // by waypoint
    std::vector<std::uint8_t> linked_;               // by edge
    std::vector<Hung> hung_;                         // ascending by number
    std::vector<std::vector<std::uint32_t>> taken_;  // by door, indices in hung_
    std::vector<std::vector<std::uint32_t>> given_;
    std::vector<std::uint8_t> shut_;
    std::vector<std::uint32_t> touched_;  // waypoints changed by the last change
    std::vector<std::uint32_t> opened_;   // waypoints and edges opened by the last change
    Aabb opened_box_;                     // box around these
    std::vector<std::uint32_t> path_;
};

}  // namespace zoned::ai::pathfinding
