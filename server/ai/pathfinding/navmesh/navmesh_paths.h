// NavmeshPaths: finds paths over the floors of a zone, one above the other, with doors that turn.
#pragma once

#include "server/ai/pathfinding/hierarchy/graph_hierarchy.h"
#include "server/ai/pathfinding/navmesh/navmesh.h"
#include "server/ai/pathfinding/requests/path_request_queue.h"

#include <vector>

namespace zoned::ai::pathfinding {

struct NavmeshPathsSettings {
    QueueSettings queue;
    /// The most polygons that one search may look at; beyond, the path goes from group to group.
    std::uint32_t search_work = 20'000;
    /// A place beside all floors is replaced by the nearest one within this distance, m.
    float reach_m = 4.0F;
};

/// It tries a free straight line over the polygons first, then NavmeshSearch. Where the tick has no
/// more work to give, the path goes from group to group of polygons. If the goal cannot be reached,
/// the path leads to the nearest reachable place (kPartial). A path is near the best; a straight
/// one is the best.
class NavmeshPaths final : public PathRequestQueue {
  public:
    /// `area` as the mesh was baked; `shut` is by door.
    NavmeshPaths(Navmesh mesh,
                 const GroundRect& area,
                 std::span<const std::uint8_t> shut,
                 const NavmeshPathsSettings& settings = {});

    void turn_doors(std::span<const std::uint8_t> shut) override;
    [[nodiscard]] bool straight(Spot from, float from_y, Spot to, float to_y) const override;
    [[nodiscard]] bool contains(Spot place) const override;

    /// The exit towards a place beyond the area. The candidates are reachable places along the
    /// sides of the area that the place lies beyond. The exit gives the shortest two straight
    /// lines.
    MapExit straight_exit(Spot from, float from_y, Spot to) override;

    [[nodiscard]] float ground(Spot place) const override;
    [[nodiscard]] float floor_along(Spot from, float from_y, Spot to) const override;
    [[nodiscard]] std::size_t bytes() const override;

    [[nodiscard]] const Navmesh& mesh() const { return mesh_; }

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
    /// Edges at a side of the area, where the zone can be left.
    struct Rim {
        std::uint32_t polygon;
        Vec3 a;
        Vec3 b;
        int side;  ///< least x, most x, least z, most z
    };

    /// The part of the ground that a change opened.
    struct OpenedBox {
        Spot low;
        Spot high;
    };

    void link_polygons();
    void find_rims();
    [[nodiscard]] NodeGraph graph() const;
    /// Sets the gates as doors are; returns true if any polygon has changed. Notes the opened
    /// parts.
    bool follow(std::span<const std::uint8_t> shut);
    void ready(std::uint32_t goal);
    bool find_straight(const PathRequestEntry& request, const End& goal, FoundPath& found);
    /// The reachable place nearest to a goal.
    End nearest_reached(const PathRequestEntry& request);
    bool find_by_clusters(const PathRequestEntry& request, const End& goal);
    void take(FoundPath& found) const;
    [[nodiscard]] Vec3 gate_between(std::uint32_t polygon, std::uint32_t next) const;

    NavmeshPathsSettings settings_;
    GroundRect area_;
    Navmesh mesh_;
    NavmeshSearch search_;
    GraphHierarchy clusters_;
    std::vector<Vec3> middles_;         // by polygon
    std::vector<std::uint32_t> first_;  // links between polygons
    std::vector<std::uint32_t> to_;
    std::vector<std::uint32_t> return_;
    std::vector<std::uint8_t> linked_;
    std::vector<std::uint8_t> open_;
    std::vector<std::uint32_t> hinged_;  // polygons that depend on doors
    std::vector<std::uint32_t> turned_;  // changed by the last change
    std::vector<Rim> rims_;
    std::vector<OpenedBox> opened_;
    std::vector<std::uint32_t> corridor_;
};

}  // namespace zoned::ai::pathfinding
