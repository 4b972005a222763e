#include "server/ai/pathfinding/requests/zone_portals.h"

#include "server/ai/pathfinding/grid/grid_path.h"
#include "shared/core/assert.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

namespace zoned::ai::pathfinding {

namespace {

constexpr float kNoPath_m = std::numeric_limits<float>::infinity();
/// To cross a border costs as much at least, so that no path goes to and fro for nothing.
constexpr float kLeastCrossing_m = 0.1F;
/// A goal in an obstacle is replaced by the nearest passable cell within so many cells.
constexpr int kReach = 8;
/// The work at a portal that a search looks at, in units of about 2 ns.
constexpr std::uint64_t kPortalUnits = 4;
/// Sides of a map: to the right, left, down, up.
constexpr unsigned kMapSides = 4;
constexpr std::array<float, kMapSides> kOutX{1.0F, -1.0F, 0.0F, 0.0F};
constexpr std::array<float, kMapSides> kOutZ{0.0F, 0.0F, 1.0F, -1.0F};

bool lies_in(const GroundRect& r, Spot s) {
    return s.x >= r.min_x && s.x <= r.max_x && s.z >= r.min_z && s.z <= r.max_z;
}

float straight_m(Spot a, Spot b) {
    return std::sqrt((a.x - b.x) * (a.x - b.x) + (a.z - b.z) * (a.z - b.z));
}

GroundRect covered(const GroundGrid& g) {
    return {g.min_x(),
            g.min_z(),
            g.min_x() + g.cell_m() * static_cast<float>(g.width()),
            g.min_z() + g.cell_m() * static_cast<float>(g.height())};
}

}  // namespace

ZonePortals::ZonePortals(std::span<const ZoneGround> zones) {
    for (const ZoneGround& z : zones) {
        zones_.push_back({z.ground->grid,
                          z.region.value_or(covered(z.ground->grid)),
                          z.origin_x,
                          z.origin_z,
                          {},
                          z.ground->cells,
                          {},
                          {}});
        zones_.back().components.label(zones_.back().cells);
    }
    // Stretches have one each at least, however many they are.
    float spacing_m = kSpacing_m;
    find_portals(zones, spacing_m);
    for (std::size_t before = ~std::size_t{0};
         portals_.size() > kMostPortals && portals_.size() < before;) {
        before = portals_.size();
        spacing_m *= 2.0F;
        find_portals(zones, spacing_m);
    }
    for (Portal& p : portals_) {
        const PortalZone& beyond = zones_[p.to];
        p.component = beyond.components.of(beyond.cells.place(p.entry));
    }
    for (const PortalZone& z : zones_) {
        for (std::uint32_t i = 0; i < z.out.size(); ++i) {
            portals_[z.out[i]].number = i;
        }
    }
}

void ZonePortals::find_portals(std::span<const ZoneGround> zones, float spacing_m) {
    portals_.clear();
    for (std::uint32_t z = 0; z < zones_.size(); ++z) {
        for (unsigned side = 0; side < kMapSides; ++side) {
            cross_side(zones, z, side, spacing_m);
        }
    }
    for (PortalZone& z : zones_) {
        z.in.clear();
        z.out.clear();
    }
    for (std::uint32_t p = 0; p < portals_.size(); ++p) {
        zones_[portals_[p].from].out.push_back(p);
        zones_[portals_[p].to].in.push_back(p);
    }
}

/// Along the outermost cells of a map on one side.
void ZonePortals::cross_side(std::span<const ZoneGround> zones,
                             std::uint32_t zone,
                             unsigned side,
                             float spacing_m) {
    const PortalZone& first = zones_[zone];
    const bool upright = side < 2;
    const int count = upright ? first.grid.height() : first.grid.width();
    const int line = side == 0 ? first.grid.width() - 1 : (side == 2 ? first.grid.height() - 1 : 0);
    std::vector<Portal> run;
    for (int i = 0; i < count; ++i) {
        const Cell exit =
            upright ? Cell{static_cast<std::uint16_t>(line), static_cast<std::uint16_t>(i)}
                    : Cell{static_cast<std::uint16_t>(i), static_cast<std::uint16_t>(line)};
        Spot at = first.grid.centre(exit);
        if (lies_in(first.region, at)) {
            // The map ends where the zone does: a step beyond, where that is the other's first
            // cell.
            at = {at.x + kOutX[side] * first.grid.cell_m(),
                  at.z + kOutZ[side] * first.grid.cell_m()};
        }
        const std::optional<std::uint32_t> other = zone_of(zone, at);
        std::optional<Portal> portal;
        if (other && *other != zone) {
            const PortalZone& second = zones_[*other];
            const Spot there = local(zone, at, *other);
            const Cell entry = second.grid.cell(there);
            const Place from = first.cells.place(exit);
            const Place to = second.cells.place(entry);
            if (second.grid.contains(there) && first.cells.passable(from) &&
                second.cells.passable(to) &&
                std::abs(zones[zone].ground->floor_m[from] - zones[*other].ground->floor_m[to]) <=
                    kStep_m) {
                portal = Portal{zone, *other, exit, entry, at, 0, 0};
            }
        }
        // Cells of the other map may be larger or smaller: a portal that does not join ends a run.
        const bool joined = portal && !run.empty() && run.back().to == portal->to &&
                            std::abs(run.back().entry.x - portal->entry.x) <= 1 &&
                            std::abs(run.back().entry.y - portal->entry.y) <= 1;
        if (!joined) {
            add_portals(run, spacing_m);
            run.clear();
        }
        if (portal) {
            run.push_back(*portal);
        }
    }
    add_portals(run, spacing_m);
}

void ZonePortals::add_portals(std::span<const Portal> run, float spacing_m) {
    if (run.empty()) {
        return;
    }
    const float length = zones_[run.front().from].grid.cell_m() * static_cast<float>(run.size());
    const auto count = static_cast<std::size_t>(std::ceil(length / spacing_m));
    for (std::size_t i = 0; i < count; ++i) {
        portals_.push_back(run[(2 * i + 1) * run.size() / (2 * count)]);
    }
}

void ZonePortals::read_row(std::uint32_t portal, const FlowField& field, PortalRow& row) const {
    const PortalZone& zone = zones_[portals_[portal].to];
    row.clear();
    for (const std::uint32_t out : zone.out) {
        row.push_back(field.cost(zone.cells.place(portals_[out].exit)));
    }
}

float ZonePortals::crossing_m(std::uint32_t portal) const {
    const Portal& p = portals_[portal];
    return std::max(kLeastCrossing_m, straight_m(zones_[p.from].grid.centre(p.exit), p.beyond));
}

std::optional<std::uint32_t> ZonePortals::zone_of(std::uint32_t zone, Spot at) const {
    for (std::uint32_t z = 0; z < zones_.size(); ++z) {
        if (lies_in(zones_[z].region, local(zone, at, z))) {
            return z;
        }
    }
    return std::nullopt;
}

Spot ZonePortals::local(std::uint32_t from, Spot at, std::uint32_t to) const {
    const PortalZone& a = zones_[from];
    const PortalZone& b = zones_[to];
    return {static_cast<float>(static_cast<double>(at.x) + (a.origin_x - b.origin_x)),
            static_cast<float>(static_cast<double>(at.z) + (a.origin_z - b.origin_z))};
}

Cost ZonePortals::across(std::uint32_t in, std::uint32_t out, const PortalRow& row) const {
    if (!row.empty()) {
        return row[portals_[out].number];
    }
    const PortalZone& zone = zones_[portals_[in].to];
    const Cell entry = portals_[in].entry;
    const Cell exit = portals_[out].exit;
    const bool joined = portals_[in].component == zone.components.of(zone.cells.place(exit));
    return joined ? octile(exit.x - entry.x, exit.y - entry.y) : kNoCost;
}

float ZonePortals::least_m(std::uint32_t portal,
                           const PortalQuery& query,
                           const Scratch& scratch) const {
    const Portal& p = portals_[portal];
    const Spot exit = local(p.from, zones_[p.from].grid.centre(p.exit), query.from);
    return scratch.left_m[portal] + crossing_m(portal) + straight_m(query.start, exit);
}

void ZonePortals::reach(std::uint32_t portal,
                        std::uint32_t next,
                        float left_m,
                        const PortalQuery& query,
                        Scratch& scratch) const {
    if (left_m < scratch.left_m[portal]) {
        scratch.left_m[portal] = left_m;
        scratch.next[portal] = next;
        scratch.open.push({least_m(portal, query, scratch), portal});
    }
}

/// The path may end in any zone whose map has the goal on it.
void ZonePortals::open_last(const PortalQuery& query, Scratch& scratch) const {
    scratch.left_m.assign(portals_.size(), kNoPath_m);
    scratch.next.resize(portals_.size());
    scratch.open.clear();
    scratch.unknown.clear();
    scratch.work = 0;
    for (std::uint32_t z = 0; z < zones_.size(); ++z) {
        const PortalZone& last = zones_[z];
        const Spot here = local(query.to, query.goal, z);
        Cell goal_cell = last.grid.cell(here);
        if (!last.grid.contains(here) ||
            (!last.cells.passable(goal_cell) &&
             !nearest_passable(last.cells, last.grid, here, kReach, goal_cell))) {
            continue;
        }
        const std::uint32_t component = last.components.of(last.cells.place(goal_cell));
        scratch.work += kPortalUnits * last.in.size();
        for (const std::uint32_t in : last.in) {
            if (portals_[in].component == component) {
                const float end_m = straight_m(last.grid.centre(portals_[in].entry), here);
                reach(in, in, end_m, query, scratch);
            }
        }
    }
}

void ZonePortals::reach_before(std::uint32_t portal,
                               const PortalQuery& query,
                               std::span<const PortalRow> rows,
                               Scratch& scratch) const {
    const PortalZone& zone = zones_[portals_[portal].from];
    const float behind_m = scratch.left_m[portal] + crossing_m(portal);
    scratch.work += kPortalUnits * zone.in.size();
    for (const std::uint32_t in : zone.in) {
        const Cost cost = across(in, portal, rows[in]);
        if (cost != kNoCost) {
            const float steps = static_cast<float>(cost) / static_cast<float>(kStraight);
            reach(in, portal, steps * zone.grid.cell_m() + behind_m, query, scratch);
        }
    }
}

void ZonePortals::find_unknown(std::uint32_t first,
                               std::span<const PortalRow> rows,
                               Scratch& scratch) const {
    for (std::uint32_t at = first; scratch.next[at] != at; at = scratch.next[at]) {
        const Cell exit = portals_[scratch.next[at]].exit;
        // A free line costs its lower bound: then the row says nothing new.
        if (rows[at].empty() && !free_line(map_beyond(at), portals_[at].entry, exit)) {
            scratch.unknown.push_back(at);
        }
    }
}

std::optional<ZonePortals::PortalExit> ZonePortals::straight_exit(std::uint32_t from,
                                                                  Spot start,
                                                                  std::uint32_t to,
                                                                  Spot goal,
                                                                  std::span<const PortalRow> rows,
                                                                  const LengthTo& length_to,
                                                                  Scratch& scratch) const {
    // A*, from the goal back to the start. No path costs less than the straight line.
    const PortalQuery query{from, start, to, goal};
    open_last(query, scratch);
    std::uint32_t first = 0;
    float best_m = kNoPath_m;
    while (!scratch.open.empty()) {
        const auto [key, at] = scratch.open.pop();
        if (key > least_m(at, query, scratch)) {
            continue;  // became cheaper since
        }
        if (!(key < best_m)) {
            break;
        }
        // Testing that a path leads there at all costs next to nothing.
        const std::optional<float> length =
            portals_[at].from == from ? length_to(portals_[at].exit) : std::nullopt;
        if (length && scratch.left_m[at] + crossing_m(at) + *length < best_m) {
            best_m = scratch.left_m[at] + crossing_m(at) + *length;
            first = at;
        }
        reach_before(at, query, rows, scratch);
    }
    if (best_m == kNoPath_m) {
        return std::nullopt;
    }
    find_unknown(first, rows, scratch);
    return PortalExit{portals_[first].beyond, best_m, !scratch.unknown.empty()};
}

std::size_t ZonePortals::bytes() const {
    std::size_t bytes = portals_.capacity() * sizeof(Portal);
    for (const PortalZone& z : zones_) {
        bytes += z.components.bytes() + 2 * z.cells.row_bits().size_bytes();
    }
    return bytes;
}

}  // namespace zoned::ai::pathfinding
