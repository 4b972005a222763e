#include "server/ai/pathfinding/requests/zone_portals.h"

#include "server/ai/pathfinding/flow_fields/flow_field.h"
#include "server/ai/pathfinding/grid/search_heap.h"
#include "shared/core/assert.h"

#include <algorithm>
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
    measure_zones();
    through_m_.assign(portals_.size() * portals_.size(), kNoPath_m);
    for (std::uint32_t p = 0; p < portals_.size(); ++p) {
        search_from(p);
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
                portal = Portal{zone, *other, exit, entry, at};
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

void ZonePortals::measure_zones() {
    FlowField field;
    for (PortalZone& z : zones_) {
        z.cost_m.clear();
        for (const std::uint32_t in : z.in) {
            field.build(z.cells, portals_[in].entry);
            for (const std::uint32_t out : z.out) {
                const Cost cost = field.cost(z.cells.place(portals_[out].exit));
                z.cost_m.push_back(cost == kNoCost
                                       ? kNoPath_m
                                       : static_cast<float>(cost) / static_cast<float>(kStraight) *
                                             z.grid.cell_m());
            }
        }
    }
}

/// Dijkstra's algorithm over portals: from beyond one, across its zone, to beyond the next.
void ZonePortals::search_from(std::uint32_t portal) {
    float* const cost = through_m_.data() + portal * portals_.size();

    struct OpenPortal {
        float key;
        std::uint32_t node;
    };

    SearchHeap<OpenPortal> open;
    cost[portal] = 0.0F;
    open.push({0.0F, portal});
    while (!open.empty()) {
        const auto [sum, at] = open.pop();
        if (sum > cost[at]) {
            continue;
        }
        const PortalZone& zone = zones_[portals_[at].to];
        const auto row = static_cast<std::size_t>(
            std::lower_bound(zone.in.begin(), zone.in.end(), at) - zone.in.begin());
        for (std::size_t i = 0; i < zone.out.size(); ++i) {
            const float next =
                sum + zone.cost_m[row * zone.out.size() + i] + crossing_m(zone.out[i]);
            if (next < cost[zone.out[i]]) {
                cost[zone.out[i]] = next;
                open.push({next, zone.out[i]});
            }
        }
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

/// For each portal out of a zone, a lower bound of the rest of a path behind it. The path may end
/// in any zone whose map has the goal on it.
void ZonePortals::promise(std::uint32_t from,
                          std::uint32_t to,
                          Spot goal,
                          std::vector<PortalChoice>& promised) const {
    promised.clear();
    for (const std::uint32_t out : zones_[from].out) {
        promised.push_back({out, out, kNoPath_m, 0.0F});
    }
    for (std::uint32_t z = 0; z < zones_.size(); ++z) {
        const PortalZone& last = zones_[z];
        const Spot here = local(to, goal, z);
        Cell goal_cell = last.grid.cell(here);
        if (!last.grid.contains(here) ||
            (!last.cells.passable(goal_cell) &&
             !nearest_passable(last.cells, last.grid, here, kReach, goal_cell))) {
            continue;
        }
        const std::uint32_t component = last.components.of(last.cells.place(goal_cell));
        for (const std::uint32_t in : last.in) {
            const Cell entry = portals_[in].entry;
            if (last.components.of(last.cells.place(entry)) != component) {
                continue;
            }
            const float end_m = straight_m(last.grid.centre(entry), here);
            for (PortalChoice& c : promised) {
                const float sum = crossing_m(c.first) + through(c.first, in) + end_m;
                if (sum < c.cost_m) {
                    c.cost_m = sum;
                    c.last = in;
                }
            }
        }
    }
}

std::optional<ZonePortals::PortalChoice> ZonePortals::choose(std::uint32_t from,
                                                             Spot start,
                                                             std::uint32_t to,
                                                             Spot goal,
                                                             const LengthTo& length_to,
                                                             Scratch& scratch) const {
    const PortalZone& first = zones_[from];
    std::vector<PortalChoice>& promised = scratch.promised;
    promise(from, to, goal, promised);
    for (PortalChoice& c : promised) {
        c.least_m = c.cost_m + straight_m(start, first.grid.centre(portals_[c.first].exit));
    }
    // Those that promise most first, each as far as its length is asked for, until none promises
    // more than the best of these.
    std::sort(promised.begin(), promised.end(), [](const PortalChoice& a, const PortalChoice& b) {
        return a.least_m != b.least_m ? a.least_m < b.least_m : a.first < b.first;
    });
    std::optional<PortalChoice> best;
    std::size_t tries = 0;
    for (const PortalChoice& c : promised) {
        if (!(c.least_m < (best ? best->cost_m : kNoPath_m)) || (best && tries >= kTries)) {
            break;
        }
        // Testing that a path leads there at all costs next to nothing.
        const std::optional<float> length = length_to(portals_[c.first].exit);
        if (!length) {
            continue;
        }
        ++tries;
        if (!best || c.cost_m + *length < best->cost_m) {
            best = {c.first, c.last, c.cost_m + *length, 0.0F};
        }
    }
    return best;
}

std::optional<Spot> ZonePortals::straight_exit(std::uint32_t from,
                                               Spot start,
                                               std::uint32_t to,
                                               Spot goal,
                                               const LengthTo& length_to,
                                               Scratch& scratch) const {
    const std::optional<PortalChoice> best = choose(from, start, to, goal, length_to, scratch);
    return best ? std::optional<Spot>(portals_[best->first].beyond) : std::nullopt;
}

PathOutcome ZonePortals::route(GridPlanner& planner,
                               std::uint32_t from,
                               Spot start,
                               std::uint32_t to,
                               Spot goal,
                               std::vector<ZonePathSegment>& segments) const {
    segments.clear();
    const PortalZone& first = zones_[from];
    const PortalZone& last = zones_[to];
    GridQuery query;
    query.start = first.grid.cell(start);
    if (!first.grid.contains(start) || !planner.map().passable(query.start)) {
        return PathOutcome::kStartBlocked;
    }
    if (!last.grid.contains(goal) || !last.cells.passable(last.grid.cell(goal))) {
        return PathOutcome::kGoalBlocked;
    }
    const auto length_to = [&](Cell c) -> std::optional<float> {
        query.goal = c;
        const GridAnswer a = planner.plan(query);
        return a.outcome == PathOutcome::kFound
                   ? std::optional<float>(static_cast<float>(a.length) * first.grid.cell_m())
                   : std::nullopt;
    };
    Scratch scratch;
    const Spot here = local(to, goal, from);
    const std::optional<float> within =
        first.grid.contains(here) ? length_to(first.grid.cell(here)) : std::nullopt;
    const std::optional<PortalChoice> best = choose(from, start, to, goal, length_to, scratch);
    if (!within && !best) {
        return PathOutcome::kUnreachable;
    }
    if (best && !(within && *within <= best->cost_m)) {
        // Portal by portal the one from which the least is left.
        std::uint32_t at = best->first;
        segments.push_back({from, portals_[at].beyond});
        while (at != best->last) {
            const PortalZone& zone = zones_[portals_[at].to];
            const auto row = static_cast<std::size_t>(
                std::lower_bound(zone.in.begin(), zone.in.end(), at) - zone.in.begin());
            std::uint32_t next = at;
            float least = kNoPath_m;
            for (std::size_t i = 0; i < zone.out.size(); ++i) {
                const float sum = zone.cost_m[row * zone.out.size() + i] + crossing_m(zone.out[i]) +
                                  through(zone.out[i], best->last);
                if (zone.out[i] != at && sum < least) {
                    least = sum;
                    next = zone.out[i];
                }
            }
            ZONED_ASSERT(next != at && segments.size() <= portals_.size(), "a path that was found");
            at = next;
            segments.push_back({portals_[at].from, portals_[at].beyond});
        }
    }
    const std::uint32_t end = segments.empty() ? from : portals_[best->last].to;
    segments.push_back({end, local(to, goal, end)});
    return PathOutcome::kFound;
}

std::size_t ZonePortals::bytes() const {
    std::size_t bytes =
        through_m_.capacity() * sizeof(float) + portals_.capacity() * sizeof(Portal);
    for (const PortalZone& z : zones_) {
        bytes += z.cost_m.capacity() * sizeof(float) + z.cells.places() * sizeof(std::uint32_t);
    }
    return bytes;
}

}  // namespace zoned::ai::pathfinding
