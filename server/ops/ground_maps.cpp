#include "server/ops/ground_maps.h"

#include "server/ai/navigation/ground_grid.h"
#include "server/ops/config_numbers.h"
#include "server/ops/read_text.h"
#include "server/zone/zone_settings.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

namespace zoned::ops {

namespace {

using ai::navigation::WaypointGraph;
using proto::Config;

/// Waypoints that a warning names.
constexpr std::size_t kNamedWaypoints = 5;

float map_cell_m(const Config::Ways& ways) {
    return narrow(ways.map() == Config::Ways::GRAPH ? ways.spacing_m() : ways.cell_m());
}

void check_waypoints(const Config::Ways& ways, Diagnostics& diagnostics) {
    if (!ways.has_waypoints()) {
        return;
    }
    if (ways.map() != Config::Ways::GRAPH) {
        diagnostics.add("ai.ways.waypoints", "waypoints are used with map: GRAPH alone");
    } else if (const auto graph = ai::navigation::parse_waypoints(ways.waypoints()); !graph) {
        diagnostics.add("ai.ways.waypoints", graph.error());
    } else if (graph->size() == 0) {
        diagnostics.add("ai.ways.waypoints", "there is no waypoint among them");
    }
}

/// "waypoints 3, 5 and 8 more TEXT"; nothing of none.
void warn_of(const WaypointGraph& graph,
             const std::vector<std::uint32_t>& numbers,
             const std::string& text,
             std::vector<std::string>& warnings) {
    if (numbers.empty()) {
        return;
    }
    std::string names = numbers.size() == 1 ? "ai.ways: waypoint " : "ai.ways: waypoints ";
    const std::size_t named = std::min(numbers.size(), kNamedWaypoints);
    for (std::size_t i = 0; i < named; ++i) {
        names += (i == 0 ? "" : ", ") + std::to_string(graph.id(numbers[i]));
    }
    if (named < numbers.size()) {
        names += " and " + std::to_string(numbers.size() - named) + " more";
    }
    warnings.push_back(names + " " + text);
}

/// By waypoint, the number of one that it is joined with, whichever way edges lead: the same for
/// all that are.
std::vector<std::uint32_t> joined_waypoints(const WaypointGraph& graph) {
    std::vector<std::uint32_t> above(graph.size());
    std::iota(above.begin(), above.end(), 0U);
    const auto top = [&above](std::uint32_t n) {
        for (; above[n] != n; n = above[n]) {
            above[n] = above[above[n]];
        }
        return n;
    };
    for (std::uint32_t n = 0; n < graph.size(); ++n) {
        for (const WaypointGraph::Edge& e : graph.edges(n)) {
            above[top(n)] = top(e.to);
        }
    }
    for (std::uint32_t n = 0; n < graph.size(); ++n) {
        above[n] = top(n);
    }
    return above;
}

}  // namespace

void load_waypoints(Config& config, Diagnostics& diagnostics) {
    if (!config.ai().ways().has_waypoints_file()) {
        return;
    }
    Config::Ways& ways = *config.mutable_ai()->mutable_ways();
    if (ways.has_waypoints()) {
        diagnostics.add("ai.ways.waypoints_file", "waypoints are given inline already");
        return;
    }
    std::string text;
    const std::string wrong = read_text(ways.waypoints_file(), text);
    if (!wrong.empty()) {
        diagnostics.add("ai.ways.waypoints_file", wrong);
        return;
    }
    ways.set_waypoints(std::move(text));
    ways.clear_waypoints_file();
}

void check_ground_maps(const Config& config,
                       const std::vector<ZoneRegion>& zones,
                       Diagnostics& diagnostics) {
    if (!config.ai().has_ways()) {
        return;
    }
    const Config::Ways& ways = config.ai().ways();
    check_waypoints(ways, diagnostics);
    if (ways.has_crowding() && ways.map() != Config::Ways::GRID) {
        diagnostics.add("ai.ways.crowding", "is of map: GRID alone");
    }
    if (ways.map() == Config::Ways::GRAPH && ways.has_waypoints()) {
        return;  // nothing is baked
    }
    const float cell_m = map_cell_m(ways);
    for (const ZoneRegion& zone : zones) {
        const std::string defect = ai::navigation::GroundGrid::defect_of(
            zone::ways_area(zone.max_x - zone.min_x,
                            zone.max_z - zone.min_z,
                            narrow(config.zones().handoff_hysteresis_m()),
                            cell_m),
            cell_m);
        if (!defect.empty()) {
            diagnostics.add(
                ways.map() == Config::Ways::GRAPH ? "ai.ways.spacing_m" : "ai.ways.cell_m",
                "zone '" + zone.name + "': " + defect);
            return;
        }
    }
}

namespace {

ai::crowd::CrowdWaysSettings expand_crowding(const Config& config) {
    const Config::Crowding& from = config.ai().ways().crowding();
    ai::crowd::CrowdWaysSettings out;
    const double ticks = from.look_s() * config.world().tick_rate_hz();
    out.look_ticks = static_cast<std::uint32_t>(std::max(1.0, std::round(ticks)));
    // After remember_s a count is worth 1 / e of what it was.
    out.remember = narrow(std::exp(-from.look_s() / from.remember_s()));
    out.jam_per_m2 = narrow(from.jam_per_m2());
    out.least_speed = narrow(from.least_speed());
    out.gain = narrow(from.gain());
    out.work_per_tick = from.work_per_tick();
    return out;
}

}  // namespace

ai::WaysSettings expand_ways(const Config& config) {
    const Config::Ways& from = config.ai().ways();
    ai::WaysSettings ways;
    ways.cell_m = map_cell_m(from);
    ways.work_per_tick = from.work_per_tick();
    ways.cell_height_m = narrow(from.cell_height_m());
    if (from.has_crowding()) {
        ways.crowding = expand_crowding(config);
    }
    switch (from.map()) {
        case Config::Ways::GRID:
            ways.map = ai::WayMapKind::kGrid;
            break;
        case Config::Ways::MESH:
            ways.map = ai::WayMapKind::kMesh;
            break;
        case Config::Ways::GRAPH:
            ways.map = ai::WayMapKind::kGraph;
            break;
    }
    if (from.has_waypoints()) {
        // What is wrong with them check_ground_maps() says.
        if (auto graph = ai::navigation::parse_waypoints(from.waypoints())) {
            ways.waypoints = std::make_shared<const WaypointGraph>(std::move(graph).value());
        }
    }
    return ways;
}

std::vector<std::string> waypoint_warnings(const Settings& settings) {
    std::vector<std::string> warnings;
    if (!settings.ai.ways.waypoints) {
        return warnings;
    }
    const WaypointGraph& graph = *settings.ai.ways.waypoints;
    const std::vector<std::uint32_t> joined = joined_waypoints(graph);
    std::vector<std::uint32_t> count(graph.size(), 0);
    std::vector<std::uint8_t> entered(graph.size(), 0);
    for (std::uint32_t n = 0; n < graph.size(); ++n) {
        ++count[joined[n]];
        for (const WaypointGraph::Edge& e : graph.edges(n)) {
            entered[e.to] = 1;
        }
    }
    const auto most =
        static_cast<std::uint32_t>(std::max_element(count.begin(), count.end()) - count.begin());
    std::vector<std::uint32_t> outside;
    std::vector<std::uint32_t> apart;
    std::vector<std::uint32_t> one_way;
    for (std::uint32_t n = 0; n < graph.size(); ++n) {
        const Vec3d at = graph.position(n).cast<double>();
        const bool inside =
            std::any_of(settings.zones.begin(), settings.zones.end(), [&at](const ZoneRegion& z) {
                return at.x() >= z.min_x && at.x() <= z.max_x && at.z() >= z.min_z &&
                       at.z() <= z.max_z;
            });
        if (!inside) {
            outside.push_back(n);
        }
        if (joined[n] != most) {
            apart.push_back(n);
        } else if (graph.size() > 1 && (entered[n] == 0 || graph.edges(n).empty())) {
            one_way.push_back(n);
        }
    }
    warn_of(graph, outside, "in no zone", warnings);
    warn_of(graph, apart, "not joined by edges with most of the others", warnings);
    warn_of(graph, one_way, "without an edge that leads there, or without one away", warnings);
    if (graph.size() == 1) {
        warnings.push_back("ai.ways: a single waypoint leads nowhere");
    }
    return warnings;
}

}  // namespace zoned::ops
