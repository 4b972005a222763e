#include "server/config/world/pathfinding_config.h"

#include "server/ai/pathfinding/grid/ground_grid.h"
#include "server/ai/pathfinding/waypoints/waypoint_graph.h"
#include "server/config/settings.h"
#include "server/config/text/config_numbers.h"
#include "server/config/text/read_text.h"
#include "server/zone/zone_settings.h"
#include "proto/config/config.pb.h"
#include "shared/core/elementary/elementary.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numeric>
#include <utility>

namespace zoned::config {

namespace {

using ai::pathfinding::WaypointGraph;
using proto::config::Config;

/// Waypoints that a warning names.
constexpr std::size_t kNamedWaypoints = 5;
/// Types that `zoned check` names.
constexpr std::size_t kNamedTypes = 8;

float map_cell_m(const proto::config::Pathfinding& paths) {
    return narrow(paths.map() == proto::config::Pathfinding::WAYPOINT_GRAPH ? paths.spacing_m()
                                                                            : paths.cell_m());
}

void check_waypoints(const proto::config::Pathfinding& paths, Diagnostics& diagnostics) {
    if (!paths.has_waypoints()) {
        return;
    }
    if (paths.map() != proto::config::Pathfinding::WAYPOINT_GRAPH) {
        diagnostics.add("ai.pathfinding.waypoints",
                        "waypoints are used with map: WAYPOINT_GRAPH alone");
    } else if (const auto graph = ai::pathfinding::parse_waypoints(paths.waypoints()); !graph) {
        diagnostics.add("ai.pathfinding.waypoints", graph.error());
    } else if (graph->size() == 0) {
        diagnostics.add("ai.pathfinding.waypoints", "there is no waypoint among them");
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
    std::string names =
        numbers.size() == 1 ? "ai.pathfinding: waypoint " : "ai.pathfinding: waypoints ";
    const std::size_t named = std::min(numbers.size(), kNamedWaypoints);
    for (std::size_t i = 0; i < named; ++i) {
        names += (i == 0 ? "" : ", ") + std::to_string(graph.id(numbers[i]));
    }
    if (named < numbers.size()) {
        names += " and " + std::to_string(numbers.size() - named) + " more";
    }
    warnings.push_back(names + " " + text);
}

/// By waypoint, the number that stands for its connected component, in whatever direction edges
/// lead.
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
    if (!config.ai().pathfinding().has_waypoints_file()) {
        return;
    }
    proto::config::Pathfinding& paths = *config.mutable_ai()->mutable_pathfinding();
    if (paths.has_waypoints()) {
        diagnostics.add("ai.pathfinding.waypoints_file", "waypoints are given inline already");
        return;
    }
    std::string text;
    const std::string wrong = read_text(paths.waypoints_file(), text);
    if (!wrong.empty()) {
        diagnostics.add("ai.pathfinding.waypoints_file", wrong);
        return;
    }
    paths.set_waypoints(std::move(text));
    paths.clear_waypoints_file();
}

void check_ground_maps(const Config& config,
                       const std::vector<ZoneRegion>& zones,
                       Diagnostics& diagnostics) {
    if (!config.ai().has_pathfinding()) {
        return;
    }
    const proto::config::Pathfinding& paths = config.ai().pathfinding();
    check_waypoints(paths, diagnostics);
    if (paths.has_crowding() && paths.map() != proto::config::Pathfinding::GRID) {
        diagnostics.add("ai.pathfinding.crowding", "is of map: GRID alone");
    }
    if (paths.has_search() && paths.map() != proto::config::Pathfinding::GRID) {
        diagnostics.add("ai.pathfinding.search", "is of map: GRID alone");
    }
    if (paths.has_search_weight() &&
        paths.search() != proto::config::Pathfinding::WEIGHTED_A_STAR) {
        diagnostics.add("ai.pathfinding.search_weight", "is of search: WEIGHTED_A_STAR alone");
    }
    if (paths.map() == proto::config::Pathfinding::NONE ||
        (paths.map() == proto::config::Pathfinding::WAYPOINT_GRAPH && paths.has_waypoints())) {
        return;  // nothing is baked
    }
    const float cell_m = map_cell_m(paths);
    for (const ZoneRegion& zone : zones) {
        const std::string defect = ai::pathfinding::GroundGrid::defect_of(
            zone::paths_area(zone.max_x - zone.min_x,
                             zone.max_z - zone.min_z,
                             narrow(config.zones().handoff_hysteresis_m()),
                             cell_m),
            cell_m);
        if (!defect.empty()) {
            diagnostics.add(paths.map() == proto::config::Pathfinding::WAYPOINT_GRAPH
                                ? "ai.pathfinding.spacing_m"
                                : "ai.pathfinding.cell_m",
                            "zone '" + zone.name + "': " + defect);
            return;
        }
    }
}

namespace {

ai::pathfinding::CrowdPathSettings expand_crowding(const Config& config) {
    const proto::config::Crowding& from = config.ai().pathfinding().crowding();
    ai::pathfinding::CrowdPathSettings out;
    const double ticks = from.look_s() * config.world().tick_rate_hz();
    out.look_ticks = static_cast<std::uint32_t>(std::max(1.0, std::round(ticks)));
    // After remember_s a count is worth 1 / e of what it was.
    out.remember = narrow(elementary::exp(-from.look_s() / from.remember_s()));
    out.jam_per_m2 = narrow(from.jam_per_m2());
    out.least_speed = narrow(from.least_speed());
    out.gain = narrow(from.gain());
    out.work_per_tick = from.work_per_tick();
    return out;
}

ai::pathfinding::GridMethod method_of(proto::config::Pathfinding::Search search) {
    using Method = ai::pathfinding::GridMethod;
    switch (search) {
        case proto::config::Pathfinding::AUTOMATIC:
            return Method::kDefault;
        case proto::config::Pathfinding::A_STAR:
            return Method::kAStar;
        case proto::config::Pathfinding::WEIGHTED_A_STAR:
            return Method::kWeightedAStar;
        case proto::config::Pathfinding::JUMP_POINTS:
            return Method::kJumpPoints;
    }
    return Method::kDefault;
}

}  // namespace

ai::PathfindingSettings expand_pathfinding(const Config& config) {
    const proto::config::Pathfinding& from = config.ai().pathfinding();
    ai::PathfindingSettings paths;
    paths.cell_m = map_cell_m(from);
    paths.work_per_tick = from.work_per_tick();
    paths.cell_height_m = narrow(from.cell_height_m());
    if (from.has_crowding()) {
        paths.crowding = expand_crowding(config);
    }
    paths.search = {method_of(from.search()), narrow(from.search_weight())};
    switch (from.map()) {
        case proto::config::Pathfinding::GRID:
            paths.map = ai::PathMapKind::kGrid;
            break;
        case proto::config::Pathfinding::NAVMESH:
            paths.map = ai::PathMapKind::kNavmesh;
            break;
        case proto::config::Pathfinding::WAYPOINT_GRAPH:
            paths.map = ai::PathMapKind::kWaypointGraph;
            break;
        case proto::config::Pathfinding::NONE:
            paths.cell_m = 0.0F;
            break;
    }
    if (from.has_waypoints()) {
        // check_ground_maps() reports the mistakes in them.
        if (auto graph = ai::pathfinding::parse_waypoints(from.waypoints())) {
            paths.waypoints = std::make_shared<const WaypointGraph>(std::move(graph).value());
        }
    }
    return paths;
}

namespace {

/// The most cells of a zone's map where the config names no cells.
constexpr double kDefaultCells = 3'000'000;
constexpr float kDefaultCell_m = 0.5F;

bool has_statics(const Settings& settings) {
    return !settings.boxes.empty() || !settings.doors.empty() || !settings.surfaces.empty();
}

/// The smallest cells that give no zone too many.
float default_cell_m(const Settings& settings) {
    float cell_m = kDefaultCell_m;
    const auto too_many = [&](const ZoneRegion& zone) {
        const double wide = zone.max_x - zone.min_x;
        const double deep = zone.max_z - zone.min_z;
        const auto cell = static_cast<double>(cell_m);
        return wide / cell * (deep / cell) > kDefaultCells ||
               !ai::pathfinding::GroundGrid::defect_of(
                    zone::paths_area(wide, deep, settings.handoff_hysteresis_m, cell_m), cell_m)
                    .empty();
    };
    while (std::any_of(settings.zones.begin(), settings.zones.end(), too_many)) {
        cell_m *= 2.0F;
    }
    return cell_m;
}

const char* name_of(ai::PathMapKind map) {
    switch (map) {
        case ai::PathMapKind::kGrid:
            return "grids";
        case ai::PathMapKind::kNavmesh:
            return "navmeshes";
        case ai::PathMapKind::kWaypointGraph:
            return "waypoints";
    }
    return "?";
}

/// Names of the types that need maps.
std::vector<std::string> travelling_types(const Settings& settings) {
    std::vector<std::string> names;
    for (std::size_t t = 0; t < settings.types.size(); ++t) {
        if (settings.ai.pathfinding.travels[t] != 0) {
            names.push_back(settings.types[t].name);
        }
    }
    return names;
}

}  // namespace

void plan_default_paths(Settings& settings) {
    ai::PathfindingSettings& paths = settings.ai.pathfinding;
    paths.travels.clear();
    for (const world::EntityType& type : settings.types) {
        const bool travels =
            type.kind == world::EntityKind::kCharacter && ai::travels(settings.ai, type.brain);
        paths.travels.push_back(travels ? 1 : 0);
    }
    if (!settings.config->ai().has_pathfinding() && has_statics(settings) &&
        !travelling_types(settings).empty()) {
        paths.cell_m = default_cell_m(settings);
    }
}

std::string pathfinding_text(const Settings& settings) {
    const ai::PathfindingSettings& paths = settings.ai.pathfinding;
    const bool asked = settings.config->ai().has_pathfinding();
    const std::vector<std::string> types = travelling_types(settings);
    if (paths.cell_m == 0.0F) {
        return std::string("paths: none: ") + (asked ? "ai.pathfinding says so"
                                               : types.empty()
                                                   ? "no type has a brain that goes to places"
                                                   : "nothing but the ground stands in the way");
    }
    std::string text = std::string("paths: over ") + name_of(paths.map);
    char cell[40];
    std::snprintf(cell, sizeof(cell), ", %.3g m", static_cast<double>(paths.cell_m));
    text += std::string(cell) + (asked ? ", as ai.pathfinding says" : ", by default") + "; for ";
    for (std::size_t i = 0; i < types.size() && i < kNamedTypes; ++i) {
        text += (i == 0 ? "" : ", ") + types[i];
    }
    return types.empty() ? text + "nobody"
           : types.size() > kNamedTypes
               ? text + " and " + std::to_string(types.size() - kNamedTypes) + " more"
               : text;
}

std::vector<std::string> waypoint_warnings(const Settings& settings) {
    std::vector<std::string> warnings;
    if (!settings.ai.pathfinding.waypoints) {
        return warnings;
    }
    const WaypointGraph& graph = *settings.ai.pathfinding.waypoints;
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
        warnings.push_back("ai.pathfinding: a single waypoint leads nowhere");
    }
    return warnings;
}

}  // namespace zoned::config
