// ZonePortals: paths that run through several zones, by the places where borders can be crossed.
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

/// The map of a zone and where it lies: world coordinates of the zone's local (0, 0). The map may
/// go beyond the zone, over parts of its neighbours.
struct ZoneGround {
    const GroundMap* ground = nullptr;
    double origin_x = 0.0;
    double origin_z = 0.0;
    std::optional<GroundRect> region;  ///< zone-local; none: what the map covers
};

/// A path's part in one zone: walk to `to`, which lies in the next zone for all parts but the last.
struct ZonePathSegment {
    std::uint32_t zone = 0;
    Spot to;  ///< in coordinates of `zone`
};

/// A zone is left by the outermost cells of its map. Where these lie in another zone (or next to
/// it), each stretch of them that can be crossed has portals, no farther apart than kSpacing_m
/// (more where a world would have more than kMostPortals); in each zone the costs of best paths
/// from the portals that lead into it to those that lead out are known, and from each portal to
/// each other the cost of the best path through zones. What is planned in a zone is exact; across
/// borders it is the best path through portals (as HpaGraph does within a zone). Doors are as
/// on the maps that it is built of.
///
/// Immutable, so that zones share it; a zone needs no more of the others than this table. Building
/// it takes a field over its zone for each portal, and a search for each; memory grows with the
/// square of the portals (4 MiB for 1,024).
class ZonePortals {
  public:
    static constexpr float kSpacing_m = 12.0F;
    static constexpr std::size_t kMostPortals = 1024;
    /// Floors on either side of a border may be so far apart, m.
    static constexpr float kStep_m = 0.5F;

    explicit ZonePortals(std::span<const ZoneGround> zones);

    /// Portal by which to leave, and the last one of the path.
    struct PortalChoice {
        std::uint32_t first;
        std::uint32_t last;
        float cost_m;   ///< from the first on; of what is chosen in all
        float least_m;  ///< with the straight line to the first
    };

    /// Memory for a question; none is allocated once it has been used.
    struct Scratch {
        std::vector<PortalChoice> promised;
    };

    /// How far it is from the start to a cell of its zone, m; nothing where no path leads there.
    using LengthTo = std::function<std::optional<float>(Cell)>;

    /// Where to leave the zone `from` for a place in zone `to`, which may be the same one: another
    /// path out and back in. In coordinates of `from`. Nothing where no path through portals leads
    /// there, or a place lies off its zone's map, or nothing near the goal is passable. At most
    /// kTries lengths are asked for, of the portals by which straight lines would be shortest; in
    /// the last zone the last part counts as the straight line.
    [[nodiscard]] std::optional<Spot> straight_exit(std::uint32_t from,
                                                    Spot start,
                                                    std::uint32_t to,
                                                    Spot goal,
                                                    const LengthTo& length_to,
                                                    Scratch& scratch) const;

    static constexpr std::size_t kTries = 16;

    /// Zones that a path from a place in one leads through, with what to walk to in each. `planner`
    /// is that of zone `from`; the ends lie on their zones' maps. kFound, kStartBlocked and
    /// kGoalBlocked (the place is not passable), kUnreachable.
    PathOutcome route(GridPlanner& planner,
                      std::uint32_t from,
                      Spot start,
                      std::uint32_t to,
                      Spot goal,
                      std::vector<ZonePathSegment>& segments) const;

    [[nodiscard]] std::size_t portals() const { return portals_.size(); }

    /// The zone that a place in the coordinates of one lies in; nothing outside the world.
    [[nodiscard]] std::optional<std::uint32_t> zone_of(std::uint32_t zone, Spot at) const;

    /// A place in the coordinates of one zone in those of another.
    [[nodiscard]] Spot local(std::uint32_t from, Spot at, std::uint32_t to) const;

    [[nodiscard]] std::size_t bytes() const;

  private:
    /// From a cell of one zone to one of another.
    struct Portal {
        std::uint32_t from;
        std::uint32_t to;
        Cell exit;    ///< of `from`'s map
        Cell entry;   ///< of `to`'s map
        Spot beyond;  ///< where `entry` is crossed into, in coordinates of `from`
    };

    struct PortalZone {
        GroundGrid grid;
        GroundRect region;
        double origin_x;
        double origin_z;
        Components components;
        GridMap cells;
        std::vector<std::uint32_t> in;   // portals, ascending
        std::vector<std::uint32_t> out;  // alike
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

    /// From its exit to beyond it.
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
