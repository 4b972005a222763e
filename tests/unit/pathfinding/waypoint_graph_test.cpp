#include "server/ai/pathfinding/waypoints/waypoint_graph.h"

#include "tests/unit/allocation_count.h"
#include "shared/core/rng.h"

#include <gmock/gmock.h>

#include <cmath>
#include <limits>

namespace zoned::ai::pathfinding {

namespace {

constexpr double kFar = std::numeric_limits<double>::infinity();

struct RandomGraph {
    std::vector<Waypoint> waypoints;
    std::vector<WaypointEdge> edges;
};

RandomGraph random_graph(std::uint32_t size, core::Rng& rng) {
    RandomGraph g;
    for (std::uint32_t i = 0; i < size; ++i) {
        g.waypoints.push_back({1000 + 7 * (size - i),
                               Vec3(rng.range(-50, 50), rng.range(0, 5), rng.range(-50, 50)),
                               rng.below(8) != 0});
    }
    for (std::uint32_t i = 0; i < 3 * size; ++i) {
        const Waypoint& a = g.waypoints[rng.below(size)];
        const Waypoint& b = g.waypoints[rng.below(size)];
        const float length = (a.position - b.position).norm();
        g.edges.push_back({a.id, b.id, length * rng.range(0.5F, 2.0F)});
    }
    return g;
}

/// Costs of best paths from a waypoint, by rounds over all edges until nothing changes (Bellman).
std::vector<double> all_costs(const WaypointGraph& graph, std::uint32_t start) {
    std::vector<double> cost(graph.size(), kFar);
    cost[start] = graph.passable(start) ? 0.0 : kFar;
    for (bool changed = true; changed;) {
        changed = false;
        for (std::uint32_t n = 0; n < graph.size(); ++n) {
            for (const WaypointGraph::Edge& e : graph.edges(n)) {
                const double sum = cost[n] + static_cast<double>(e.weight);
                if (graph.passable(e.to) && sum < cost[e.to]) {
                    cost[e.to] = sum;
                    changed = true;
                }
            }
        }
    }
    return cost;
}

void expect_best(const WaypointGraph& graph, WaypointSearch& search, core::Rng& rng) {
    const std::uint32_t start = rng.below(graph.size());
    const std::vector<double> best = all_costs(graph, start);
    for (std::uint32_t goal = 0; goal < graph.size(); ++goal) {
        const WaypointSearch::WaypointAnswer a = search.plan(graph, start, goal);
        if (!graph.passable(start) || !graph.passable(goal)) {
            EXPECT_TRUE(a.outcome == PathOutcome::kStartBlocked ||
                        a.outcome == PathOutcome::kGoalBlocked);
            continue;
        }
        ASSERT_EQ(a.outcome == PathOutcome::kFound, best[goal] != kFar);
        if (best[goal] == kFar) {
            continue;
        }
        // Sums of at most some hundred weights in doubles, in one order or another.
        ASSERT_NEAR(a.cost, best[goal], 1e-9 * (1.0 + best[goal]));
        double along = 0.0;
        for (std::size_t i = 1; i < search.path().size(); ++i) {
            double least = kFar;
            for (const WaypointGraph::Edge& e : graph.edges(search.path()[i - 1])) {
                least = e.to == search.path()[i] ? std::min<double>(least, e.weight) : least;
            }
            along += least;
        }
        ASSERT_EQ(search.path().front(), start);
        ASSERT_EQ(search.path().back(), goal);
        ASSERT_NEAR(along, a.cost, 1e-9 * (1.0 + a.cost));
    }
}

TEST(WaypointSearch, IsExactAlsoAfterDoorsAndWeightsChange) {
    core::Rng rng(41);
    for (int i = 0; i < 20; ++i) {
        const RandomGraph g = random_graph(20 + 15 * static_cast<std::uint32_t>(i), rng);
        auto graph = WaypointGraph::build(g.waypoints, g.edges);
        ASSERT_TRUE(graph);
        WaypointSearch search;
        for (int round = 0; round < 6; ++round) {
            expect_best(*graph, search, rng);
            const std::uint32_t door = rng.below(graph->size());
            graph->set_passable(door, !graph->passable(door));
            const WaypointEdge& e = g.edges[rng.below(static_cast<std::uint32_t>(g.edges.size()))];
            EXPECT_TRUE(graph->set_weight(graph->number_of(e.from),
                                          graph->number_of(e.to),
                                          round == 2 ? 0.0F : e.weight / 9));
        }
    }
}

TEST(WaypointSearch, NamesWhatCantBeAnsweredAndAllocatesNothingOnceWarm) {
    core::Rng rng(42);
    const RandomGraph g = random_graph(400, rng);
    const auto graph = WaypointGraph::build(g.waypoints, g.edges);
    ASSERT_TRUE(graph);
    WaypointSearch search;
    EXPECT_EQ(search.plan(*graph, 400, 0).outcome, PathOutcome::kOffMap);
    EXPECT_EQ(graph->number_of(1), graph->size());
    for (int round = 0; round < 2; ++round) {
        const std::uint64_t before = allocation_count();
        for (std::uint32_t i = 0; i < 400; ++i) {
            search.plan(*graph, i, (i * 7) % 400);
        }
        EXPECT_TRUE(round == 0 || allocation_count() == before);
    }
    std::uint32_t start = 0;
    while (search.plan(*graph, start, (start * 7) % 400).work < 10) {
        ++start;
    }
    EXPECT_EQ(search.plan(*graph, start, (start * 7) % 400, 3).outcome, PathOutcome::kCutOff);
}

TEST(WaypointGraph, FindsTheNearestWaypoint) {
    core::Rng rng(43);
    const RandomGraph g = random_graph(300, rng);
    const auto graph = WaypointGraph::build(g.waypoints, g.edges);
    ASSERT_TRUE(graph);
    for (int i = 0; i < 300; ++i) {
        const Vec3 place(rng.range(-60, 60), rng.range(-5, 9), rng.range(-60, 60));
        float least = 1e9F;
        for (const Waypoint& w : g.waypoints) {
            least = w.passable ? std::min(least, (w.position - place).norm()) : least;
        }
        EXPECT_NEAR((graph->position(graph->nearest(place)) - place).norm(), least, 1e-4F);
    }
    EXPECT_EQ(WaypointGraph::build({}, {})->nearest(Vec3::Zero()), 0U);
}

TEST(ParseWaypoints, ReadsWhatIsWritten) {
    const auto graph = parse_waypoints(
        "# a bridge\n"
        "edge 7 9 length both  # before its nodes\n"
        "node 7 0 0 0\r\n"
        "\n"
        "node 9 3 0 4\n"
        "node 12 -1.5 2e1 .25 blocked\n"
        "edge 9 12 2.5\n");
    ASSERT_TRUE(graph) << graph.error();
    ASSERT_EQ(graph->size(), 3U);
    EXPECT_EQ(graph->number_of(12), 2U);
    EXPECT_FALSE(graph->passable(2));
    EXPECT_EQ(graph->position(2), Vec3(-1.5F, 20.0F, 0.25F));
    WaypointSearch search;
    EXPECT_EQ(search.plan(*graph, 1, 0).cost, 5.0);
    EXPECT_EQ(graph->edges(1).size(), 2U);
}

TEST(ParseWaypoints, NamesTheLineOfWhatIsWrong) {
    const auto wrong = [](std::string_view text) {
        const auto graph = parse_waypoints(text);
        return graph ? "fine" : graph.error();
    };
    EXPECT_EQ(wrong("node 1 0 0 0\npoint 2\n"), "line 2: a line begins with node or edge");
    EXPECT_EQ(wrong("node 1 0 0\n"), "line 1: expected: node ID X Y Z [blocked]");
    EXPECT_EQ(wrong("node -1 0 0 0\n"), "line 1: expected: node ID X Y Z [blocked]");
    EXPECT_EQ(wrong("node 4294967296 0 0 0\n"), "line 1: expected: node ID X Y Z [blocked]");
    EXPECT_EQ(wrong("node 1 inf 0 0\n"), "line 1: expected: node ID X Y Z [blocked]");
    EXPECT_EQ(wrong("node 1 0 0 0 shut\n"),
              "line 1: after a node's place only 'blocked' may follow");
    EXPECT_EQ(wrong("node 1 0 0 0\n\nnode 1 1 1 1"), "line 3: node 1 is given twice");
    EXPECT_EQ(wrong("node 1 0 0 0\nedge 1 2 3\nnode 3 0 0 0"), "line 2: there is no node 2");
    EXPECT_EQ(wrong("node 1 0 0 0\nedge 1 1 -3\n"), "line 2: a weight is 0 or more");
    EXPECT_EQ(wrong("node 1 0 0 0\nedge 1 1 nan\n"), "line 2: a weight is 0 or more");
    EXPECT_EQ(wrong("node 1 0 0 0\nedge 1 1 3x\n"), "line 2: expected: edge FROM TO WEIGHT [both]");
    EXPECT_EQ(wrong("node 1 0 0 0\nedge 1 1 3 both ways\n"),
              "line 2: after an edge's weight only 'both' may follow");
    EXPECT_EQ(wrong("node 1 -3e38 0 0\nnode 2 3e38 0 0\nedge 1 2 length\n"),
              "line 3: an edge too long for a weight");
}

}  // namespace

}  // namespace zoned::ai::pathfinding
