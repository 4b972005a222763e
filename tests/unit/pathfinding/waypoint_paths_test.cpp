// Waypoint paths: along placed waypoints, whatever their weights, and through doors.
#include "server/ai/pathfinding/waypoints/waypoint_paths.h"

#include "tests/unit/pathfinding/walkers.h"

#include <gtest/gtest.h>

namespace zoned::ai::pathfinding {

namespace {

const motion::CharacterLimits kGraphWalker;

/// A square of four waypoints 20 m to a side: 1 (0, 0), 2 (20, 0), 3 (20, 20), 4 (0, 20); by 4 it
/// is dearer.
WaypointGraph square() {
    auto graph = parse_waypoints(
        "node 1 0 0 0\nnode 2 20 0 0\nnode 3 20 0 20\nnode 4 0 0 20\n"
        "edge 1 2 length both\nedge 2 3 length both\nedge 1 4 30 both\nedge 4 3 30 both\n");
    EXPECT_TRUE(graph.ok());
    return std::move(graph).value();
}

motion::StaticGeometry with_door(const motion::StaticBox& box) {
    motion::Door door;
    door.box = box;
    door.times.period = 1000;
    door.times.open = {{1, 2}};
    return {{}, 0.0F, motion::kStaticCell_m, {}, {door}};
}

std::vector<Spot> path_of(WaypointPaths& paths,
                          const PathRequest& ask,
                          PathOutcome outcome = PathOutcome::kFound) {
    const PathRequestId t = paths.ask(ask);
    paths.serve();
    EXPECT_EQ(paths.answer(t).outcome, outcome);
    const std::span<const Spot> corners = paths.answer(t).corners;
    std::vector<Spot> out(corners.begin(), corners.end());
    paths.release(t);
    return out;
}

TEST(WaypointPaths, LeadAlongTheLeastSumOfWeightsAndStraightToTheGoal) {
    WaypointPaths paths(square(), {}, {});
    EXPECT_EQ(path_of(paths, {0, {-2.0F, -2.0F}, {22.0F, 23.0F}}),
              (std::vector<Spot>{{0, 0}, {20, 0}, {20, 20}, {22, 23}}));
    EXPECT_EQ(path_of(paths, {0, {-2.0F, -2.0F}, {3.0F, 1.0F}}), (std::vector<Spot>{{3, 1}}))
        << "the same waypoint is nearest to both";
    EXPECT_EQ(path_of(paths, {0, {3.0F, 0.5F}, {20.2F, 16.0F}}),
              (std::vector<Spot>{{20, 0}, {20.2F, 16}}))
        << "neither back to the first waypoint nor beyond the goal";
    EXPECT_TRUE(paths.straight({-2.0F, 0.0F}, 0.0F, {2.0F, 0.0F}, 0.0F));
    EXPECT_FALSE(paths.straight({-2.0F, 0.0F}, 0.0F, {19.0F, 0.0F}, 0.0F));
}

TEST(WaypointPaths, FollowOneWayEdgesAndSayHowNearTheyGet) {
    auto graph = parse_waypoints(
        "node 1 0 0 0\nnode 2 10 0 0\nnode 3 20 0 0\nnode 9 31 0 0\n"
        "edge 1 2 length\nedge 2 3 length\nedge 2 1 length\n");
    WaypointPaths paths(std::move(graph).value(), {}, {});
    EXPECT_EQ(path_of(paths, {0, {0, 1}, {20, 1}}),
              (std::vector<Spot>{{0, 0}, {10, 0}, {20, 0}, {20, 1}}));
    EXPECT_EQ(path_of(paths, {0, {20, 1}, {0, 1}}, PathOutcome::kPartial),
              (std::vector<Spot>{{20, 0}}));
    EXPECT_EQ(path_of(paths, {0, {-4, 5}, {31, 0}}, PathOutcome::kPartial).back(), (Spot{20, 0}));
}

TEST(WaypointPaths, KeepOffEdgesThatPassThroughADoorThatIsShut) {
    // On the middle of the edge from 1 to 2, turned by half a right angle.
    const motion::StaticGeometry world =
        with_door(static_box(Vec3(10.0F, 1.5F, 1.6F), Vec3(0.2F, 1.5F, 1.5F), 45.0F));
    const WaypointGraph graph = square();
    const std::vector<WaypointDoor> doors = waypoint_doors(graph, world, kGraphWalker);
    ASSERT_EQ(doors.size(), 1U);
    EXPECT_EQ(doors[0].taken.size(), 2U) << "both ways along one edge";
    EXPECT_TRUE(doors[0].given.empty());
    WaypointPaths paths(graph, doors, std::vector<std::uint8_t>{0});
    const PathRequestId a = paths.ask({0, {0, -1}, {20, 21}});
    const PathRequestId b = paths.ask({1, {20, -1}, {20, 21}});
    paths.serve();
    paths.turn_doors(std::vector<std::uint8_t>{1});
    ASSERT_EQ(paths.requeued().size(), 1U);
    EXPECT_EQ(paths.requeued()[0], a.slot);
    EXPECT_FALSE(paths.answer(b).waiting);
    paths.serve();
    EXPECT_EQ(paths.answer(a).corners[1], (Spot{0, 20})) << "the dearer path";
    paths.turn_doors(std::vector<std::uint8_t>{0});
    EXPECT_EQ(paths.requeued().size(), 1U) << "the door is a short cut for one of them";
    paths.serve();
    EXPECT_EQ(paths.answer(a).corners[1], (Spot{20, 0}));
}

TEST(WaypointPaths, PassUnderADoorThatIsHighAndOverABridgeWhileItIsThere) {
    const WaypointGraph graph = square();
    // 2.5 m up: it touches no head; at 1.5 m it does.
    EXPECT_TRUE(waypoint_doors(graph,
                               with_door(static_box(Vec3(10, 3.0F, 0), Vec3(0.5F, 0.5F, 2.0F))),
                               kGraphWalker)[0]
                    .taken.empty());
    EXPECT_EQ(waypoint_doors(graph,
                             with_door(static_box(Vec3(10, 2.0F, 0), Vec3(0.5F, 0.5F, 2.0F))),
                             kGraphWalker)[0]
                  .taken.size(),
              2U);
    const motion::StaticGeometry bridge =
        with_door(static_box(Vec3(10.0F, -0.3F, 0.0F), Vec3(3.0F, 0.3F, 2.0F)));
    const std::vector<WaypointDoor> doors = waypoint_doors(graph, bridge, kGraphWalker);
    EXPECT_TRUE(doors[0].taken.empty());
    EXPECT_EQ(doors[0].given.size(), 2U);
    WaypointPaths paths(graph, doors, std::vector<std::uint8_t>{0});
    EXPECT_EQ(path_of(paths, {0, {0, -1}, {20, 1}})[1], (Spot{0, 20})) << "all the way round";
    paths.turn_doors(std::vector<std::uint8_t>{1});
    EXPECT_EQ(path_of(paths, {0, {0, -1}, {20, 1}}).size(), 3U);
}

TEST(WaypointPaths, LeaveBlockedWaypointsOutWhateverDoorsDo) {
    auto graph = parse_waypoints(
        "node 1 0 0 0\nnode 2 10 0 0 blocked\nnode 3 20 0 0\nedge 1 2 1 both\nedge 2 3 1 both\n");
    const motion::StaticGeometry world =
        with_door(static_box(Vec3(10.0F, 1.5F, 0.0F), Vec3(0.2F, 1.5F, 1.0F)));
    const std::vector<WaypointDoor> doors = waypoint_doors(*graph, world, kGraphWalker);
    WaypointPaths paths(std::move(graph).value(), doors, std::vector<std::uint8_t>{1});
    paths.turn_doors(std::vector<std::uint8_t>{0});
    EXPECT_EQ(path_of(paths, {0, {0, 1}, {20, 1}}, PathOutcome::kPartial).back(), (Spot{0, 0}));
}

}  // namespace

}  // namespace zoned::ai::pathfinding
