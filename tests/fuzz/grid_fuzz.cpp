// Fuzzing of grid maps and scenarios: any text is refused with a line, or gives a map on which all
// exact methods agree.
#include "server/ai/pathfinding/grid_search/grid_planner.h"
#include "server/ai/pathfinding/waypoints/waypoint_graph.h"
#include "tests/fuzz/fuzz.h"
#include "tests/scenario/grid_text.h"
#include "shared/core/assert.h"

#include <string_view>

namespace zoned::fuzz {

namespace {

using namespace ai::pathfinding;

constexpr std::size_t kMaxText = 20000;
/// Larger maps are read, but no paths are looked for on them.
constexpr std::uint32_t kMostPlaces = 20000;

template <class R>
bool read_or_refused(const R& result) {
    ZONED_ASSERT(result || result.error().starts_with("line "), "a refusal names the line");
    return result.ok();
}

/// From the first passable cell to some others, by all exact methods.
void use_map(const GridMap& map) {
    GridPlanner planner(map);
    planner.prepare();
    GridQuery query;
    bool started = false;
    std::uint32_t seen = 0;
    for (Place p = 0; p < map.places(); ++p) {
        if (!map.passable(p)) {
            continue;
        }
        query.start = started ? query.start : map.cell(p);
        started = true;
        if (seen++ % 37 != 0) {
            continue;
        }
        query.goal = map.cell(p);
        const GridAnswer best = planner.plan(query, GridMethod::kAStar);
        for (const GridMethod m :
             {GridMethod::kJumpPoints, GridMethod::kSubgoals, GridMethod::kHubLabels}) {
            if (planner.can(m)) {
                const GridAnswer a = planner.plan(query, m);
                ZONED_ASSERT(a.outcome == best.outcome && a.cost == best.cost,
                             "exact methods agree");
            }
        }
    }
}

/// Between the first waypoints: a found path costs no more than its first edge or its path back.
void use_waypoints(const WaypointGraph& graph) {
    WaypointSearch search;
    const std::uint32_t count = std::min(graph.size(), 20U);
    for (std::uint32_t a = 0; a < count; ++a) {
        for (std::uint32_t b = 0; b < count; ++b) {
            const WaypointSearch::WaypointAnswer found = search.plan(graph, a, b);
            ZONED_ASSERT(found.outcome != PathOutcome::kFound ||
                             (search.path().front() == a && search.path().back() == b),
                         "a path from start to goal");
        }
        for (const WaypointGraph::Edge& e : graph.edges(a)) {
            ZONED_ASSERT(!graph.passable(a) || !graph.passable(e.to) ||
                             search.plan(graph, a, e.to).cost <= static_cast<double>(e.weight),
                         "no path is dearer than an edge");
        }
    }
}

Bytes text_seed(std::string_view text) {
    return {text.begin(), text.end()};
}

}  // namespace

std::vector<Bytes> seeds() {
    return {
        text_seed(
            "type octile\nheight 5\nwidth 7\nmap\n.......\n.@@T.W.\n.@...G.\n.@.OO..\n...S.@.\n"),
        text_seed("type octile\r\nheight 2\r\nwidth 2\r\nmap\r\n.@\r\n..\r\n"),
        text_seed("version 1\n0\tm.map\t9\t8\t1\t2\t3\t4\t2.82843\r\n1 m 9 8 8 7 0 0 10.4\n"),
        text_seed("type patch\npatches 2\npatch 0\nheight 1\nwidth 2\nmap\n@.\npatch "
                  "1\nheight 1\nwidth 1\nmap\n.\n"),
        text_seed(
            "node 1 0 0 0\nnode 2 3 0 4 blocked\nedge 1 2 length both # x\nnode 3 1 1 1\nedge "
            "3 1 2.5\nedge 1 3 0\n"),
        text_seed("version 2\nheight 4\nwidth 5\ncost 1 octile\ncommands\nQ 0 0 1 4 3 5.2\nP 0 "
                  "1 3 2\n")};
}

}  // namespace zoned::fuzz

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    using namespace zoned::fuzz;
    const std::string_view text(reinterpret_cast<const char*>(data), std::min(size, kMaxText));
    const auto map = zoned::scenario::parse_grid_map(text);
    if (read_or_refused(map) && map->places() <= kMostPlaces) {
        use_map(*map);
    }
    const auto waypoints = zoned::ai::pathfinding::parse_waypoints(text);
    if (read_or_refused(waypoints)) {
        use_waypoints(*waypoints);
    }
    read_or_refused(zoned::scenario::parse_grid_scenario(text));
    read_or_refused(zoned::scenario::parse_grid_patches(text));
    read_or_refused(zoned::scenario::parse_grid_events(text));
    return 0;
}
