// ZonePortals: plans paths that run through several zones, by portals where borders can be crossed.
#pragma once

#include "server/ai/pathfinding/grid/components.h"
#include "server/ai/pathfinding/grid/ground_map.h"
#include "server/ai/pathfinding/grid_search/grid_planner.h"

#include <array>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <vector>

namespace zoned::ai::pathfinding {

/// ZoneGround: the map of a zone, and the world coordinates of the zone's local (0, 0). The map may
/// go beyond the zone, over parts of its neighbours.
struct ZoneGround {
    const GroundMap* ground = nullptr;
    double origin_x = 0.0;
    double origin_z = 0.0;
    std::optional<GroundRect> region;  ///< zone-local; none: all that the map covers
};

/// A path's part in one zone: walk to `to`. For all parts but the last, `to` lies in the next zone.
struct ZonePathSegment {
    std::uint32_t zone = 0;
    Spot to;  ///< in coordinates of `zone`
};

/// A zone is left by the outermost cells of its map. Where these lie in another zone (or next to
/// it), each stretch of them that can be crossed has portals. Portals are no farther apart than
/// kSpacing_m (more where a world would have more than kMostPortals). The table holds the costs of
/// best paths in each zone from the portals into it to the portals out of it. It also holds the
/// cost of the best path through zones between any two portals.
///
/// Plans within a zone are exact; across borders they are the best path through portals
/// (hierarchical planning, HPA*). Source: Botea, Mueller and Schaeffer, "Near optimal hierarchical
/// path-finding", Journal of Game Development 1, 2004. Doors are as on the maps from which it is
/// built.
///
/// Immutable, so that zones share it; a zone needs nothing else of the others. Building it takes a
/// field over its zone and a search for each portal. Memory grows with the square of the portals (4
/// MiB for 1,024).
class ZonePortals {
  public:
    static constexpr float kSpacing_m = 12.0F;
    static constexpr std::size_t kMostPortals = 1024;
    /// The largest difference of floors on the two sides of a border, m.
    static constexpr float kStep_m = 0.5F;

    explicit ZonePortals(std::span<const ZoneGround> zones);

    /// The portal by which to leave, and the last one of the path.
    struct PortalChoice {
        std::uint32_t first;
        std::uint32_t last;
        float cost_m;   ///< cost from the first portal on; for the chosen one, of the whole path
        float least_m;  ///< cost_m plus the straight line to the first portal
    };

    /// Memory for a query; nothing is allocated once it has been used.
    struct Scratch {
        std::vector<PortalChoice> promised;
    };

    /// The distance from the start to a cell of its zone, m; nothing where no path leads there.
    using LengthTo = std::function<std::optional<float>(Cell)>;

    /// The place at which to leave the zone `from` for a place in zone `to`, in coordinates of
    /// `from`. Both may be the same zone: the path then leads out and back in. Nothing where no
    /// path through portals leads there, a place lies off its zone's map, or nothing near the goal
    /// is passable. At most kTries lengths are asked for, for the portals with the shortest
    /// straight lines. In the last zone the last part counts as the straight line.
    [[nodiscard]] std::optional<Spot> straight_exit(std::uint32_t from,
                                                    Spot start,
                                                    std::uint32_t to,
                                                    Spot goal,
                                                    const LengthTo& length_to,
                                                    Scratch& scratch) const;

    static constexpr std::size_t kTries = 16;

    /// The zones that a path from one place to another crosses, with the point to walk to in each.
    /// `planner` must be that of zone `from`; the ends must lie on their zones' maps. kFound,
    /// kUnreachable, or kStartBlocked and kGoalBlocked (the place is not passable).
    PathOutcome route(GridPlanner& planner,
                      std::uint32_t from,
                      Spot start,
                      std::uint32_t to,
                      Spot goal,
                      std::vector<ZonePathSegment>& segments) const;

    [[nodiscard]] std::size_t portals() const { return portals_.size(); }

    /// The zone that contains a place given in the coordinates of zone `zone`; nothing outside the
    /// world.
    [[nodiscard]] std::optional<std::uint32_t> zone_of(std::uint32_t zone, Spot at) const;

    /// Converts a place from the coordinates of one zone to those of another.
    [[nodiscard]] Spot local(std::uint32_t from, Spot at, std::uint32_t to) const;

    [[nodiscard]] std::size_t bytes() const;

  private:
    /// Portal: a step from a cell of one zone to a cell of another.
    struct Portal {
        std::uint32_t from;
        std::uint32_t to;
        Cell exit;    ///< on `from`'s map
        Cell entry;   ///< on `to`'s map
        Spot beyond;  ///< position of `entry`, in coordinates of `from`
    };

    struct PortalZone {
        GroundGrid grid;
        GroundRect region;
        double origin_x;
        double origin_z;
        Components components;
        GridMap cells;
        std::vector<std::uint32_t> in;   // portals into the zone, ascending
        std::vector<std::uint32_t> out;  // portals out of the zone, ascending
        std::vector<float> cost_m;       // by portal in, by portal out; infinite for no path
    };

    void find_portals(std::span<const ZoneGround> zones, float spacing_m);
    void cross_side(std::span<const ZoneGround> zones,
                    std::uint32_t zone,
                    unsigned side,
                    float spacing_m);
    void add_portals(std::span<const Portal> run, float spacing_m);
    void measure_zones();
    void search_from(std::uint32_t portal);
    [[nodiscard]] std::optional<PortalChoice> choose(std::uint32_t from,
                                                     Spot start,
                                                     std::uint32_t to,
                                                     Spot goal,
                                                     const LengthTo& length_to,
                                                     Scratch& scratch) const;
    void promise(std::uint32_t from,
                 std::uint32_t to,
                 Spot goal,
                 std::vector<PortalChoice>& promised) const;

    /// The length from its exit to its entry beyond.
    [[nodiscard]] float crossing_m(std::uint32_t portal) const;

    [[nodiscard]] float through(std::uint32_t first, std::uint32_t last) const {
        return through_m_[first * portals_.size() + last];
    }

    std::vector<PortalZone> zones_;
    std::vector<Portal> portals_;
    std::vector<float>
        through_m_;  // from beyond one portal to beyond another; infinite for no path
};

}  // namespace zoned::ai::pathfinding
