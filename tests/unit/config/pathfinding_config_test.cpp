// Pathfinding in a config: the ground that paths lead over, permitted settings and mistakes.
#include "server/config/world/pathfinding_config.h"

#include "server/ai/pathfinding/waypoints/waypoint_graph.h"
#include "server/config/expand/load_settings.h"
#include "tests/unit/config/config_helpers.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

namespace zoned::config::test {
namespace {

std::string with_paths(const std::string& paths) {
    return kValid + "ai { pathfinding { " + paths + " } }\n";
}

std::string graph_of(const std::string& waypoints) {
    return with_paths("map: WAYPOINT_GRAPH waypoints: \"" + waypoints + "\"");
}

TEST(PathfindingInConfigs, AreExpanded) {
    const Outcome grid = parse(with_paths(""));
    ASSERT_TRUE(grid.ok);
    EXPECT_EQ(grid.settings.ai.pathfinding.map, ai::PathMapKind::kGrid);
    EXPECT_EQ(grid.settings.ai.pathfinding.search.method, ai::pathfinding::GridMethod::kDefault);
    const Outcome weighted = parse(with_paths("search: WEIGHTED_A_STAR search_weight: 3"));
    ASSERT_TRUE(weighted.ok) << format_errors("test", weighted.errors);
    EXPECT_EQ(weighted.settings.ai.pathfinding.search.method,
              ai::pathfinding::GridMethod::kWeightedAStar);
    EXPECT_EQ(weighted.settings.ai.pathfinding.search.weight, 3.0F);
    const Outcome mesh = parse(with_paths("map: NAVMESH cell_m: 0.25 cell_height_m: 0.1"));
    ASSERT_TRUE(mesh.ok);
    EXPECT_EQ(mesh.settings.ai.pathfinding.map, ai::PathMapKind::kNavmesh);
    EXPECT_EQ(mesh.settings.ai.pathfinding.cell_height_m, 0.1F);
    const Outcome lattice = parse(with_paths("map: WAYPOINT_GRAPH spacing_m: 3"));
    ASSERT_TRUE(lattice.ok);
    EXPECT_EQ(lattice.settings.ai.pathfinding.map, ai::PathMapKind::kWaypointGraph);
    EXPECT_EQ(lattice.settings.ai.pathfinding.cell_m, 3.0F);
    EXPECT_EQ(lattice.settings.ai.pathfinding.waypoints, nullptr);
    const Outcome placed =
        parse(graph_of("node 1 0 0 0\\nnode 7 9 0 0 # east\\nedge 1 7 length both\\n"));
    ASSERT_TRUE(placed.ok) << format_errors("test", placed.errors);
    ASSERT_NE(placed.settings.ai.pathfinding.waypoints, nullptr);
    EXPECT_EQ(placed.settings.ai.pathfinding.waypoints->size(), 2U);
    EXPECT_TRUE(waypoint_warnings(placed.settings).empty());
}

const std::string kWall = "statics { box { x_m: 20 y_m: 1 size { x_m: 1 y_m: 2 z_m: 9 } } }\n";

/// The cells of the maps; 0: none. And the reason.
void expect_paths(const std::string& text, float cell_m, const std::string& reason) {
    SCOPED_TRACE(reason);
    const Outcome out = parse(text);
    ASSERT_TRUE(out.ok) << format_errors("test", out.errors);
    EXPECT_EQ(out.settings.ai.pathfinding.cell_m, cell_m);
    EXPECT_EQ(pathfinding_text(out.settings), "paths: " + reason);
}

TEST(PathfindingInConfigs, AreOnByDefaultWhereAgentsGoToPlacesAndSomethingStandsInTheWay) {
    expect_paths(kValid, 0.0F, "none: nothing but the ground stands in the way");
    expect_paths(kValid + kWall, 0.5F, "over grids, 0.5 m, by default; for guard");
    expect_paths(with("action: CHASE", "action: FLEE") + kWall,
                 0.0F,
                 "none: no type has a brain that goes to places");
    expect_paths(with("  brain: \"guard\"\n", "") + kWall,
                 0.0F,
                 "none: no type has a brain that goes to places");
    expect_paths(with_paths("map: NONE") + kWall, 0.0F, "none: ai.pathfinding says so");
    expect_paths(
        with_paths("cell_m: 0.4"), 0.4F, "over grids, 0.4 m, as ai.pathfinding says; for guard");
}

TEST(PathfindingInConfigs, HaveCellsByDefaultOfWhichNoZoneHasTooMany) {
    const auto wide = [](const std::string& half_m) {
        std::string text = with("max_x_m: 100\n", "max_x_m: " + half_m + "\n");
        return with("zones {\n",
                    "zones {\n  zone { name: \"far\" min_x_m: 100 min_z_m: -50 max_x_m: " + half_m +
                        " max_z_m: 50 }\n",
                    text);
    };
    expect_paths(wide("1100") + kWall, 0.5F, "over grids, 0.5 m, by default; for guard");
    // More than three million cells of 0.5 m, and 8192 to a side.
    const std::string extent = "replication { quantization { horizontal_extent_m: 5000 } }\n";
    expect_paths(wide("8000") + kWall + extent, 1.0F, "over grids, 1 m, by default; for guard");
    expect_paths(wide("9100") + kWall + extent, 2.0F, "over grids, 2 m, by default; for guard");
}

TEST(PathfindingInConfigs, HaveMapsForTypesThatGoToPlaces) {
    const Outcome out =
        parse(kValid + kWall +
              "type { name: \"sheep\" kind: CHARACTER capsule { radius_m: 0.3 length_m: 0.2 } "
              "brain: \"herd\" }\n"
              "brain { name: \"herd\" state { name: \"graze\" action: FLOCK } }\n");
    ASSERT_TRUE(out.ok) << format_errors("test", out.errors);
    std::vector<std::string> travel;
    for (std::size_t t = 0; t < out.settings.types.size(); ++t) {
        if (out.settings.ai.pathfinding.travels[t] != 0) {
            travel.push_back(out.settings.types[t].name);
        }
    }
    EXPECT_EQ(travel, std::vector<std::string>{"guard"});
}

TEST(PathfindingInConfigs, LeadAroundCrowdsWhereTheySaySo) {
    EXPECT_FALSE(parse(with_paths("")).settings.ai.pathfinding.crowding);
    const Outcome out =
        parse(with_paths("crowding { look_s: 1 remember_s: 2 jam_per_m2: 1.6 gain: 0.3 }"));
    ASSERT_TRUE(out.ok) << format_errors("test", out.errors);
    const ai::pathfinding::CrowdPathSettings& crowding = *out.settings.ai.pathfinding.crowding;
    EXPECT_EQ(crowding.look_ticks, static_cast<std::uint32_t>(out.settings.tick_rate_hz));
    EXPECT_NEAR(crowding.remember, 0.6065F, 1e-4F);
    EXPECT_EQ(crowding.jam_per_m2, 1.6F);
    EXPECT_EQ(crowding.gain, 0.3F);
    expect_single(with_paths("map: NAVMESH crowding { }"), "crowding {", "GRID alone");
    expect_single(with_paths("map: NAVMESH search: A_STAR"), "search: A_STAR", "GRID alone");
    expect_single(
        with_paths("search: A_STAR search_weight: 2"), "search_weight: 2", "WEIGHTED_A_STAR alone");
    expect_single(
        with_paths("search: WEIGHTED_A_STAR search_weight: 17"), "search_weight: 17", "[1");
}

TEST(PathfindingInConfigs, NameTheLineOfAMistakeAmongWaypoints) {
    expect_single(graph_of("node 1 0 0 0\\nnode 1 9 0 0\\n"), "waypoints:", "line 2: node 1");
    expect_single(graph_of("node 1 0 0 0\\nedge 1 2 length\\n"), "waypoints:", "no node 2");
    expect_single(graph_of("# nothing\\n"), "waypoints:", "no waypoint");
    expect_single(with_paths("map: NAVMESH waypoints: \"node 1 0 0 0\""),
                  "waypoints:",
                  "map: WAYPOINT_GRAPH");
    expect_single(with_paths("map: WAYPOINT_GRAPH waypoints_file: \"/none/such.txt\""),
                  "waypoints_file",
                  "/none/such.txt");
    expect_single(
        with_paths("map: WAYPOINT_GRAPH waypoints: \"node 1 0 0 0\" waypoints_file: \"x\""),
        "waypoints_file",
        "inline already");
    expect_single(with_paths("map: WAYPOINT_GRAPH spacing_m: 0.1"), "spacing_m", "out of range");
}

TEST(PathfindingInConfigs, WarnOfWaypointsThatNobodyGetsTo) {
    const Outcome out = parse(
        graph_of("node 1 0 0 0\\nnode 2 9 0 0\\nnode 3 500 0 0\\nnode 4 50 0 9\\nnode 5 20 0 0\\n"
                 "edge 1 2 length both\\nedge 2 3 length both\\nedge 2 5 length\\n"));
    ASSERT_TRUE(out.ok) << format_errors("test", out.errors);
    EXPECT_EQ(
        waypoint_warnings(out.settings),
        (std::vector<std::string>{
            "ai.pathfinding: waypoint 3 in no zone",
            "ai.pathfinding: waypoint 4 not joined by edges with most of the others",
            "ai.pathfinding: waypoint 5 without an edge that leads there, or without one away"}));
}

TEST(PathfindingInConfigs, ReadWaypointsFromAFileBesideTheConfig) {
    const std::filesystem::path folder =
        std::filesystem::path(testing::TempDir()) / "pathfinding_in_configs";
    std::filesystem::create_directories(folder);
    std::ofstream(folder / "town.txtpb")
        << with_paths("map: WAYPOINT_GRAPH waypoints_file: \"town.paths\"");
    std::ofstream(folder / "town.paths") << "node 1 0 0 0\nnode 2 5 0 0\nedge 1 2 length both\n";
    Settings settings;
    std::vector<ConfigError> errors;
    ASSERT_TRUE(load_settings((folder / "town.txtpb").string(), {}, settings, errors))
        << format_errors("town", errors);
    ASSERT_NE(settings.ai.pathfinding.waypoints, nullptr);
    EXPECT_EQ(settings.ai.pathfinding.waypoints->size(), 2U);
    // A recording holds the waypoints: the config needs no file any more.
    EXPECT_FALSE(settings.config->ai().pathfinding().has_waypoints_file());
    EXPECT_NE(settings.config->ai().pathfinding().waypoints().find("node 2 5 0 0"),
              std::string::npos);
    std::filesystem::remove_all(folder);
}

}  // namespace
}  // namespace zoned::config::test
