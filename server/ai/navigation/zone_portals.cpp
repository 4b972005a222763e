#include "server/ai/navigation/zone_portals.h"

#include "server/ai/navigation/goal_field.h"
#include "shared/core/assert.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace zoned::ai::navigation {

namespace {

/// Borders of two zones are one where they are no farther apart, m.
constexpr double kSameBorder_m = 1e-3;

Vec3 world_position(const GroundGrid& grid, double origin_x, double origin_z, Cell c) {
    const Spot at = grid.centre(c);
    return {static_cast<float>(origin_x + static_cast<double>(at.x)),
            0.0F,
            static_cast<float>(origin_z + static_cast<double>(at.z))};
}

/// Sides of a map's rectangle in the world.
struct Sides {
    double min_x, min_z, max_x, max_z;
};

Sides sides_of(const GroundGrid& g, double origin_x, double origin_z) {
    const double cell = static_cast<double>(g.cell_m());
    const double x = origin_x + static_cast<double>(g.min_x());
    const double z = origin_z + static_cast<double>(g.min_z());
    return {x, z, x + cell * g.width(), z + cell * g.height()};
}

}  // namespace

ZonePortals::ZonePortals(std::span<const ZoneGround> zones) {
    for (const ZoneGround& z : zones) {
        zones_.push_back({z.ground->grid, z.origin_x, z.origin_z, {}, z.ground->cells, {}});
        zones_.back().components.label(zones_.back().cells);
    }
    for (std::uint32_t a = 0; a < zones_.size(); ++a) {
        for (std::uint32_t b = 0; b < zones_.size(); ++b) {
            if (a != b) {
                cross(zones, a, b);
            }
        }
    }
    join_sides();
}

/// Portals from zone a to zone b where b lies to the right of a, or below it.
void ZonePortals::cross(std::span<const ZoneGround> zones, std::uint32_t a, std::uint32_t b) {
    const Zone& first = zones_[a];
    const Zone& second = zones_[b];
    const Sides p = sides_of(first.grid, first.origin_x, first.origin_z);
    const Sides q = sides_of(second.grid, second.origin_x, second.origin_z);
    const bool right = std::abs(p.max_x - q.min_x) <= kSameBorder_m;
    const bool below = std::abs(p.max_z - q.min_z) <= kSameBorder_m;
    const bool beside = right && p.min_z < q.max_z && q.min_z < p.max_z;
    if (!beside && !(below && p.min_x < q.max_x && q.min_x < p.max_x)) {
        return;
    }
    const int count = beside ? first.grid.height() : first.grid.width();
    std::vector<std::array<Cell, 2>> run;
    for (int i = 0; i <= count; ++i) {
        bool open = false;
        std::array<Cell, 2> pair;
        if (i < count) {
            const auto along = static_cast<std::uint16_t>(i);
            pair[0] = beside ? Cell{static_cast<std::uint16_t>(first.grid.width() - 1), along}
                             : Cell{along, static_cast<std::uint16_t>(first.grid.height() - 1)};
            const Spot at = first.grid.centre(pair[0]);
            const float half = 0.5F * second.grid.cell_m();
            // Just beyond the border, in coordinates of the second.
            const double x = beside ? q.min_x + static_cast<double>(half)
                                    : first.origin_x + static_cast<double>(at.x);
            const double z = beside ? first.origin_z + static_cast<double>(at.z)
                                    : q.min_z + static_cast<double>(half);
            const Spot there{static_cast<float>(x - second.origin_x),
                             static_cast<float>(z - second.origin_z)};
            pair[1] = second.grid.cell(there);
            const Place from = first.cells.place(pair[0]);
            const Place to = second.cells.place(pair[1]);
            open =
                second.grid.contains(there) && first.cells.passable(from) &&
                second.cells.passable(to) &&
                std::abs(zones[a].ground->floor_m[from] - zones[b].ground->floor_m[to]) <= kStep_m;
        }
        if (open) {
            // Cells of the second may be larger or smaller: what does not join ends a run.
            const bool joined = run.empty() || (std::abs(run.back()[1].x - pair[1].x) <= 1 &&
                                                std::abs(run.back()[1].y - pair[1].y) <= 1);
            if (!joined) {
                add_portals(a, b, run);
                run.clear();
            }
            run.push_back(pair);
        } else {
            add_portals(a, b, run);
            run.clear();
        }
    }
}

void ZonePortals::add_portals(std::uint32_t a,
                              std::uint32_t b,
                              std::span<const std::array<Cell, 2>> run) {
    const float length = zones_[a].grid.cell_m() * static_cast<float>(run.size());
    const auto count = static_cast<std::size_t>(std::ceil(length / kSpacing_m));
    for (std::size_t i = 0; i < count; ++i) {
        const std::array<Cell, 2>& pair = run[(2 * i + 1) * run.size() / (2 * count)];
        const auto number = static_cast<std::uint32_t>(sides_.size());
        sides_.push_back({a, pair[0], number + 1});
        sides_.push_back({b, pair[1], number});
        zones_[a].sides.push_back(number);
        zones_[b].sides.push_back(number + 1);
    }
}

void ZonePortals::join_sides() {
    std::vector<Waypoint> waypoints;
    std::vector<WaypointEdge> edges;
    for (std::uint32_t s = 0; s < sides_.size(); ++s) {
        const Zone& z = zones_[sides_[s].zone];
        waypoints.push_back(
            {s, world_position(z.grid, z.origin_x, z.origin_z, sides_[s].cell), true});
    }
    GoalField field;
    for (const Zone& z : zones_) {
        for (const std::uint32_t s : z.sides) {
            const std::uint32_t twin = sides_[s].twin;
            edges.push_back({s, twin, (waypoints[s].position - waypoints[twin].position).norm()});
            field.build(z.cells, sides_[s].cell);
            for (const std::uint32_t t : z.sides) {
                const Cost cost = field.cost(z.cells.place(sides_[t].cell));
                if (t != s && cost != kNoCost) {
                    edges.push_back({s,
                                     t,
                                     static_cast<float>(cost) / static_cast<float>(kStraight) *
                                         z.grid.cell_m()});
                }
            }
        }
    }
    auto graph = WaypointGraph::build(waypoints, edges);
    ZONED_ASSERT(graph.ok(), "portals make a graph");
    graph_ = std::move(graph).value();
}

Spot ZonePortals::local(std::uint32_t zone, std::uint32_t side) const {
    const Zone& from = zones_[sides_[side].zone];
    const Zone& to = zones_[zone];
    const Spot at = from.grid.centre(sides_[side].cell);
    return {static_cast<float>(from.origin_x + static_cast<double>(at.x) - to.origin_x),
            static_cast<float>(from.origin_z + static_cast<double>(at.z) - to.origin_z)};
}

Outcome ZonePortals::route(Planner& planner,
                           std::uint32_t from,
                           Spot start,
                           std::uint32_t to,
                           Spot goal,
                           std::vector<ZoneLeg>& legs) {
    legs.clear();
    const Zone& first = zones_[from];
    const Zone& last = zones_[to];
    Query query;
    query.start = first.grid.cell(start);
    const Cell goal_cell = last.grid.cell(goal);
    if (!first.grid.contains(start) || !planner.map().passable(query.start)) {
        return Outcome::kStartBlocked;
    }
    if (!last.grid.contains(goal) || !last.cells.passable(goal_cell)) {
        return Outcome::kGoalBlocked;
    }
    double within = -1.0;
    const auto cell_m = static_cast<double>(first.grid.cell_m());
    if (from == to) {
        query.goal = goal_cell;
        const Answer a = planner.plan(query);
        within = a.outcome == Outcome::kFound ? a.length * cell_m : -1.0;
    }
    starts_.clear();
    for (const std::uint32_t s : first.sides) {
        query.goal = sides_[s].cell;
        const Answer a = planner.plan(query);
        if (a.outcome == Outcome::kFound) {
            starts_.push_back({s, a.length * cell_m});
        }
    }
    ends_.clear();
    const std::uint32_t component = last.components.of(last.cells.place(goal_cell));
    for (const std::uint32_t s : last.sides) {
        if (last.components.of(last.cells.place(sides_[s].cell)) != component) {
            continue;
        }
        if (from == to) {  // the way out and back is held against the one within
            query.start = sides_[s].cell;
            query.goal = goal_cell;
            ends_.push_back({s, planner.plan(query).length * cell_m});
        } else {
            const Spot at = last.grid.centre(sides_[s].cell);
            const double dx = static_cast<double>(at.x) - static_cast<double>(goal.x);
            const double dz = static_cast<double>(at.z) - static_cast<double>(goal.z);
            ends_.push_back({s, std::sqrt(dx * dx + dz * dz)});
        }
    }
    const WaypointSearch::Answer through = search_.plan(graph_, starts_, ends_);
    if (through.outcome == Outcome::kFound && (within < 0.0 || through.cost < within)) {
        for (const std::uint32_t s : search_.way()) {
            const Side& side = sides_[s];
            if (legs.empty() || legs.back().zone != side.zone) {
                legs.push_back({side.zone, {}});
            }
            legs.back().to = local(side.zone, side.twin);
        }
    } else if (within < 0.0) {
        return Outcome::kUnreachable;
    }
    if (legs.empty() || legs.back().zone != to) {
        legs.push_back({to, {}});
    }
    legs.back().to = goal;
    return Outcome::kFound;
}

}  // namespace zoned::ai::navigation
