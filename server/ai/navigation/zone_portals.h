// ZonePortals: ways that run through several zones, by the places where borders can be crossed.
#pragma once

#include "server/ai/navigation/ground_map.h"
#include "server/ai/navigation/planner.h"
#include "server/ai/navigation/waypoint_graph.h"

#include <array>
#include <cstdint>
#include <span>
#include <vector>

namespace zoned::ai::navigation {

/// The map of a zone and where it lies: world coordinates of the zone's local (0, 0).
struct ZoneGround {
    const GroundMap* ground = nullptr;
    double origin_x = 0.0;
    double origin_z = 0.0;
};

/// A way's part in one zone: walk to `to`, which lies just inside the next zone for all parts but
/// the last.
struct ZoneLeg {
    std::uint32_t zone = 0;
    Spot to;  ///< in coordinates of `zone`
};

/// Each stretch of a border that can be crossed has portals in it, no farther apart than
/// kSpacing_m; in each zone the costs of best ways between its portals are known. What is planned
/// in a zone is exact; across borders it is the best way through portals (as ClusterGraph does
/// within a zone). Immutable once built, so that zones share it; takes no part in what zones plan
/// within themselves. Building it takes a field over its zone for each portal.
class ZonePortals {
  public:
    static constexpr float kSpacing_m = 12.0F;
    /// Floors on either side of a border may be so far apart, m.
    static constexpr float kStep_m = 0.5F;

    explicit ZonePortals(std::span<const ZoneGround> zones);

    /// Zones that a way from a place in one leads through, with what to walk to in each. `planner`
    /// is that of zone `from`; the ends lie on their zones' maps. kFound, kStartBlocked and
    /// kGoalBlocked (the place is not passable), kUnreachable. No more than the portals of the
    /// first zone are asked for of `planner`; in the goal's zone the last part counts as the
    /// straight line.
    Outcome route(Planner& planner,
                  std::uint32_t from,
                  Spot start,
                  std::uint32_t to,
                  Spot goal,
                  std::vector<ZoneLeg>& legs);

    [[nodiscard]] std::size_t portals() const { return graph_.size() / 2; }

    [[nodiscard]] const WaypointGraph& graph() const { return graph_; }

  private:
    /// One side of a portal; `graph_` has a waypoint of the same number.
    struct Side {
        std::uint32_t zone;
        Cell cell;
        std::uint32_t twin;
    };

    struct Zone {
        GroundGrid grid;
        double origin_x;
        double origin_z;
        Components components;
        GridMap cells;
        std::vector<std::uint32_t> sides;
    };

    void cross(std::span<const ZoneGround> zones, std::uint32_t a, std::uint32_t b);
    void add_portals(std::uint32_t a, std::uint32_t b, std::span<const std::array<Cell, 2>> run);
    void join_sides();
    [[nodiscard]] Spot local(std::uint32_t zone, std::uint32_t side) const;

    std::vector<Zone> zones_;
    std::vector<Side> sides_;
    WaypointGraph graph_;
    WaypointSearch search_;
    std::vector<WaypointSearch::End> starts_;
    std::vector<WaypointSearch::End> ends_;
};

}  // namespace zoned::ai::navigation
