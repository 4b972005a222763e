// ZonePortals: plans paths that run through several zones, by portals where borders can be crossed.
#pragma once

#include "server/ai/pathfinding/flow_fields/flow_field.h"
#include "server/ai/pathfinding/grid/components.h"
#include "server/ai/pathfinding/grid/ground_map.h"
#include "server/ai/pathfinding/grid/search_heap.h"

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

/// The costs from beyond a portal to each portal out of the zone there.
using PortalRow = std::vector<Cost>;

/// A zone is left by the outermost cells of its map. Where these lie in another zone (or next to
/// it), each stretch of them that can be crossed has portals. Portals are no farther apart than
/// kSpacing_m (more where a world would have more than kMostPortals).
///
/// Plans within a zone are exact; across borders they are the best path through portals
/// (hierarchical planning, HPA*). Source: Botea, Mueller and Schaeffer, "Near optimal hierarchical
/// path-finding", Journal of Game Development 1, 2004. Doors are as on the maps from which it is
/// built.
///
/// The costs of paths across zones are not found beforehand: a field over a zone for each portal
/// took most of the start of a large world, and few are ever needed. A search takes an unknown cost
/// at its lower bound, and names those that its best path depends on. Once none is named the path
/// is the best one. Source: Dellin and Srinivasa, "A unifying formalism for shortest path problems
/// with expensive edge evaluations via lazy best-first search", ICAPS 2016. PortalCosts keeps the
/// known costs.
///
/// Immutable, so that zones share it; a zone needs nothing else of the others.
class ZonePortals {
  public:
    static constexpr float kSpacing_m = 12.0F;
    static constexpr std::size_t kMostPortals = 1024;
    /// The largest difference of floors on the two sides of a border, m.
    static constexpr float kStep_m = 0.5F;

    explicit ZonePortals(std::span<const ZoneGround> zones);

    /// PortalExit: the place at which to leave a zone.
    struct PortalExit {
        Spot at;
        float cost_m = 0.0F;  ///< of the whole path; less than that where it is rough
        /// Not all costs that the choice depends on are known yet: they are Scratch::unknown.
        bool rough = false;
    };

    struct OpenPortal {
        float key;
        std::uint32_t node;
    };

    /// Memory for a query; nothing is allocated once it has been used.
    struct Scratch {
        std::vector<float> left_m;        ///< by portal, from beyond it to the goal
        std::vector<std::uint32_t> next;  ///< by portal, the next one; itself for the last one
        SearchHeap<OpenPortal> open;
        std::vector<std::uint32_t> unknown;  ///< portals whose rows are not known
        std::uint64_t work = 0;              ///< in units of about 2 ns
    };

    /// The distance from the start to a cell of its zone, m; nothing where no path leads there.
    using LengthTo = std::function<std::optional<float>(Cell)>;

    /// The place at which to leave the zone `from` for a place in zone `to`, in coordinates of
    /// `from`. Both may be the same zone: the path then leads out and back in. Nothing where no
    /// path through portals leads there, a place lies off its zone's map, or nothing near the goal
    /// is passable. Lengths are asked for as long as a portal's straight line promises less than
    /// the best so far. (A limit on their number led walkers to and fro between mazes.) In the last
    /// zone the last part counts as the straight line. `rows`: by portal, empty where not known.
    [[nodiscard]] std::optional<PortalExit> straight_exit(std::uint32_t from,
                                                          Spot start,
                                                          std::uint32_t to,
                                                          Spot goal,
                                                          std::span<const PortalRow> rows,
                                                          const LengthTo& length_to,
                                                          Scratch& scratch) const;

    /// The map of the zone beyond a portal, and the cell at which it is entered.
    [[nodiscard]] const GridMap& map_beyond(std::uint32_t portal) const {
        return zones_[portals_[portal].to].cells;
    }

    [[nodiscard]] Cell entry(std::uint32_t portal) const { return portals_[portal].entry; }

    /// The portals out of the zone beyond a portal, ascending; a PortalRow is in their order.
    [[nodiscard]] std::span<const std::uint32_t> out_of_beyond(std::uint32_t portal) const {
        return zones_[portals_[portal].to].out;
    }

    /// The row of a portal, by the field of its entry over the map beyond it.
    void read_row(std::uint32_t portal, const FlowField& field, PortalRow& row) const;

    [[nodiscard]] std::size_t portals() const { return portals_.size(); }

    /// The zone that contains a place given in the coordinates of zone `zone`; nothing outside the
    /// world.
    [[nodiscard]] std::optional<std::uint32_t> zone_of(std::uint32_t zone, Spot at) const;

    /// Converts a place from the coordinates of one zone to those of another.
    [[nodiscard]] Spot local(std::uint32_t from, Spot at, std::uint32_t to) const;

    [[nodiscard]] std::size_t bytes() const;

  private:
    /// A path from a start in one zone to a goal in another, each in the coordinates of its zone.
    struct PortalQuery {
        std::uint32_t from;
        Spot start;
        std::uint32_t to;
        Spot goal;
    };

    /// Portal: a step from a cell of one zone to a cell of another.
    struct Portal {
        std::uint32_t from;
        std::uint32_t to;
        Cell exit;                ///< on `from`'s map
        Cell entry;               ///< on `to`'s map
        Spot beyond;              ///< position of `entry`, in coordinates of `from`
        std::uint32_t component;  ///< of `entry`
        std::uint32_t number;     ///< among the portals out of `from`
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
    };

    void find_portals(std::span<const ZoneGround> zones, float spacing_m);
    void cross_side(std::span<const ZoneGround> zones,
                    std::uint32_t zone,
                    unsigned side,
                    float spacing_m);
    void add_portals(std::span<const Portal> run, float spacing_m);
    /// Opens the search at the portals from which the goal is a walk within the last zone.
    void open_last(const PortalQuery& query, Scratch& scratch) const;
    /// Reaches the portals from beyond which a path leads to `portal`.
    void reach_before(std::uint32_t portal,
                      const PortalQuery& query,
                      std::span<const PortalRow> rows,
                      Scratch& scratch) const;
    void reach(std::uint32_t portal,
               std::uint32_t next,
               float left_m,
               const PortalQuery& query,
               Scratch& scratch) const;
    /// The least cost of a path from the start by this portal, as far as it is known.
    [[nodiscard]] float least_m(std::uint32_t portal,
                                const PortalQuery& query,
                                const Scratch& scratch) const;
    /// The cost from beyond a portal to another one out of the zone there; where the row is not
    /// known, the least that it can be.
    [[nodiscard]] Cost across(std::uint32_t in, std::uint32_t out, const PortalRow& row) const;
    /// Fills Scratch::unknown along the path that begins with that portal.
    void find_unknown(std::uint32_t first, std::span<const PortalRow> rows, Scratch& scratch) const;

    /// The length from its exit to its entry beyond.
    [[nodiscard]] float crossing_m(std::uint32_t portal) const;

    std::vector<PortalZone> zones_;
    std::vector<Portal> portals_;
};

}  // namespace zoned::ai::pathfinding
