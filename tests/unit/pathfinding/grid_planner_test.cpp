#include "server/ai/pathfinding/grid_search/grid_planner.h"

#include "tests/scenario/grid_text.h"
#include "tests/unit/allocation_count.h"
#include "tests/unit/pathfinding/grid_reference.h"
#include "shared/core/rng.h"

#include <gmock/gmock.h>

#include <fstream>
#include <optional>
#include <sstream>

namespace zoned::ai::pathfinding {

using namespace scenario;

namespace {

constexpr GridMethod kExact[] = {GridMethod::kDefault,
                                 GridMethod::kAStar,
                                 GridMethod::kJumpPoints,
                                 GridMethod::kSubgoals,
                                 GridMethod::kHubLabels};

/// A best path by Cost may be longer than the best by the error that cost.h states: 3.7e-7 a
/// diagonal, of which maps here have at most 10,000.
constexpr double kCostError = 3.7e-3;

GridQuery from_to(Cell start, Cell goal) {
    GridQuery q;
    q.start = start;
    q.goal = goal;
    return q;
}

Cell any_passable(const GridMap& map, core::Rng& rng) {
    while (true) {
        const Cell c{
            static_cast<std::uint16_t>(rng.below(static_cast<std::uint32_t>(map.width()))),
            static_cast<std::uint16_t>(rng.below(static_cast<std::uint32_t>(map.height())))};
        if (map.passable(c)) {
            return c;
        }
    }
}

double length_to(const GridMap& map, const std::vector<double>& lengths, Cell c) {
    return lengths[static_cast<std::size_t>(c.y) * static_cast<std::size_t>(map.width()) + c.x];
}

/// All exact methods from one cell to some others, against Dijkstra.
void expect_exact(GridPlanner& planner, core::Rng& rng, int goals, const std::string& name) {
    const GridMap& map = planner.map();
    const Cell start = any_passable(map, rng);
    const std::vector<double> lengths = all_lengths(map, start);
    for (int i = 0; i < goals; ++i) {
        const Cell goal = any_passable(map, rng);
        const double best = length_to(map, lengths, goal);
        for (const GridMethod method : kExact) {
            if (!planner.can(method)) {
                continue;
            }
            const GridAnswer a = planner.plan(from_to(start, goal), method);
            ASSERT_EQ(a.outcome, best == kNoPath ? PathOutcome::kUnreachable : PathOutcome::kFound)
                << name;
            if (best == kNoPath) {
                continue;
            }
            ASSERT_NEAR(a.length, best, kCostError)
                << name << " " << to_string(method) << " from " << start.x << ", " << start.y
                << " to " << goal.x << ", " << goal.y;
            ASSERT_EQ(wrong_with(map, start, goal, a.length, planner.path().corners()), "")
                << name << " " << to_string(method);
        }
    }
}

TEST(GridPlanner, IsExactByEachMethodOnRandomMaps) {
    core::Rng rng(1);
    for (std::uint64_t seed = 1; seed <= 120; ++seed) {
        const int width = 1 + static_cast<int>(rng.below(seed % 3 == 0 ? 130 : 24));
        const int height = 1 + static_cast<int>(rng.below(seed % 3 == 1 ? 130 : 24));
        GridMap map = random_map(width, height, 0.05F * static_cast<float>(seed % 10), seed);
        if (map.passable_cells() == 0) {
            continue;
        }
        GridPlanner planner(map);
        planner.prepare();
        ASSERT_TRUE(planner.can(GridMethod::kHubLabels));
        for (int start = 0; start < 4; ++start) {
            expect_exact(planner, rng, 30, "seed " + std::to_string(seed));
        }
    }
}

TEST(GridPlanner, IsExactByEachMethodInRooms) {
    core::Rng rng(2);
    for (std::uint64_t seed = 1; seed <= 12; ++seed) {
        GridPlanner planner(rooms_map(97, 75, 4 + static_cast<int>(seed), seed));
        planner.prepare();
        for (int start = 0; start < 6; ++start) {
            expect_exact(planner, rng, 40, "rooms of " + std::to_string(4 + seed));
        }
    }
}

/// A map of tests/conformance, with its queries.
void read_published(const std::string& name,
                    std::optional<GridMap>& map,
                    std::vector<GridInstance>& instances) {
    const std::string file = ZONED_SOURCE_DIR "/tests/conformance/movingai/" + name + ".map";
    std::stringstream map_text;
    std::stringstream scenario_text;
    map_text << std::ifstream(file).rdbuf();
    scenario_text << std::ifstream(file + ".scen").rdbuf();
    auto read = parse_grid_map(map_text.str());
    auto queries = parse_grid_scenario(scenario_text.str());
    ASSERT_TRUE(read) << read.error();
    ASSERT_TRUE(queries) << queries.error();
    map = std::move(*read);
    instances = std::move(*queries);
    ASSERT_GE(instances.size(), 160U);
}

TEST(GridPlanner, FindsThePublishedLengthsOfBestWays) {
    for (const std::string name : {"arena", "den312d"}) {
        std::optional<GridMap> map;
        std::vector<GridInstance> instances;
        read_published(name, map, instances);
        GridPlanner planner(std::move(*map));
        planner.prepare();
        for (const GridInstance& i : instances) {
            for (const GridMethod method : kExact) {
                const GridAnswer a = planner.plan(from_to(i.start, i.goal), method);
                ASSERT_EQ(a.outcome, PathOutcome::kFound) << name << " line " << i.line;
                // The scenarios round to six digits.
                ASSERT_NEAR(a.length, i.length, 0.001) << name << " line " << i.line;
            }
        }
    }
}

TEST(GridPlanner, IsExactRightAfterEachChange) {
    core::Rng rng(3);
    GridPlanner planner(rooms_map(61, 47, 6, 5));
    planner.prepare();
    for (int round = 0; round < 60; ++round) {
        std::vector<CellChange> changes;
        for (std::uint32_t n = 1 + rng.below(5); n > 0; --n) {
            const Cell c{static_cast<std::uint16_t>(rng.below(61)),
                         static_cast<std::uint16_t>(rng.below(47))};
            changes.push_back({c, !planner.map().passable(c)});
        }
        planner.change(changes);
        if (round % 3 == 2) {
            planner.prepare();
        }
        expect_exact(planner, rng, 20, "round " + std::to_string(round));
    }
}

TEST(GridPlanner, IsExactByLandmarksAsDoorsShutAndOpenOrWallsFall) {
    core::Rng rng(4);
    std::uint32_t work = 0;
    std::uint32_t plain_work = 0;
    for (std::uint64_t seed = 1; seed <= 4; ++seed) {
        GridPlanner planner(seed % 2 == 0 ? random_map(90, 70, 0.3F, seed)
                                          : rooms_map(90, 70, 6, seed));
        IndexBounds bounds;
        bounds.labels.labels = 0;
        bounds.doors = seed <= 2 ? 100 : bounds.doors;  // no subgoals either
        planner.prepare(bounds);
        ASSERT_EQ(planner.choice(), seed <= 2 ? GridMethod::kJumpPoints : GridMethod::kSubgoals);
        const std::size_t index = planner.index_bytes();
        ASSERT_GT(index, 16U * 2U * 90U * 70U);
        for (int round = 0; round < 40; ++round) {
            std::vector<CellChange> changes;
            for (std::uint32_t n = 1 + rng.below(5); n > 0; --n) {
                const Cell c{static_cast<std::uint16_t>(rng.below(90)),
                             static_cast<std::uint16_t>(rng.below(70))};
                // Mostly shut: the landmarks' bounds on the map before are still true then.
                const bool passable = round % 4 == 3 && !planner.map().passable(c);
                changes.push_back({c, passable});
            }
            planner.change(changes);
            if (round % 8 == 7 || (seed > 2 && round % 2 != 0)) {
                planner.begin_index(bounds);
                planner.advance_index(~std::uint64_t{0});
            }
            GridPlanner plain(planner.map());
            for (int i = 0; i < 12; ++i) {
                const GridQuery q =
                    from_to(any_passable(plain.map(), rng), any_passable(plain.map(), rng));
                const GridAnswer a = planner.plan(q);
                const GridAnswer b = plain.plan(q, GridMethod::kAStar);
                ASSERT_EQ(a.outcome, b.outcome);
                ASSERT_EQ(a.cost, b.cost) << seed << " round " << round;
                if (seed <= 2) {
                    work += a.work;
                    plain_work += plain.plan(q, GridMethod::kJumpPoints).work;
                }
            }
        }
    }
    EXPECT_LT(work, plain_work * 3 / 4);
}

TEST(GridPlanner, MakesLandmarksOnlyWherePathsAreLongerThanOnAnEmptyMap) {
    IndexBounds bounds;
    bounds.doors = 0;  // neither subgoals nor labels
    for (const float blocked : {0.01F, 0.3F}) {
        GridPlanner planner(random_map(200, 150, blocked, 5));
        planner.prepare(bounds);
        EXPECT_EQ(planner.index_bytes() > 0, blocked > 0.1F) << blocked;
        core::Rng rng(17);
        expect_exact(planner, rng, 20, std::to_string(blocked));
        planner.begin_index(bounds);
        planner.advance_index(~std::uint64_t{0});
        EXPECT_LT(planner.index_work(), 1000U) << "it is not tried again: " << blocked;
    }
}

TEST(GridPlanner, KeepsItsIndexWhereAChangeChangesNothing) {
    GridPlanner planner(random_map(20, 20, 0.2F, 1));
    planner.prepare();
    const CellChange same{{3, 3}, planner.map().passable(Cell{3, 3})};
    planner.change(std::span(&same, 1));
    EXPECT_TRUE(planner.can(GridMethod::kHubLabels));
    const CellChange other{{3, 3}, !same.passable};
    planner.change(std::span(&other, 1));
    EXPECT_FALSE(planner.can(GridMethod::kHubLabels));
    EXPECT_EQ(planner.choice(), GridMethod::kJumpPoints);
    EXPECT_EQ(planner.index_bytes(), 0U);
}

TEST(GridPlanner, NamesWhyThereIsNoWay) {
    GridPlanner planner(map_of({"..#..", "..#..", "..#.#"}));
    planner.prepare();
    for (const GridMethod method : kExact) {
        EXPECT_EQ(planner.plan(from_to({0, 0}, {5, 0}), method).outcome, PathOutcome::kOffMap);
        EXPECT_EQ(planner.plan(from_to({0, 3}, {0, 0}), method).outcome, PathOutcome::kOffMap);
        EXPECT_EQ(planner.plan(from_to({2, 0}, {0, 0}), method).outcome,
                  PathOutcome::kStartBlocked);
        EXPECT_EQ(planner.plan(from_to({0, 0}, {2, 1}), method).outcome, PathOutcome::kGoalBlocked);
        EXPECT_EQ(planner.plan(from_to({0, 0}, {3, 0}), method).outcome, PathOutcome::kUnreachable);
        const GridAnswer here = planner.plan(from_to({1, 1}, {1, 1}), method);
        EXPECT_EQ(here.outcome, PathOutcome::kFound);
        EXPECT_EQ(here.length, 0.0);
        EXPECT_EQ(planner.path().corners().size(), 1U);
    }
}

TEST(GridPlanner, GoesAsNearAsItCanWhereItIsToldTo) {
    GridPlanner planner(map_of({".....#..", ".###.#..", "...#.#..", "...#..#.", "........"}));
    planner.change(std::vector<CellChange>{{{7, 4}, false}, {{6, 4}, false}, {{7, 3}, false}});
    planner.prepare();
    for (const GridMethod method : kExact) {
        GridQuery q = from_to({0, 2}, {7, 1});
        q.nearest = true;
        const GridAnswer a = planner.plan(q, method);
        EXPECT_EQ(a.outcome, PathOutcome::kPartial);
        // (5, 3) is two columns and two rows away, all others that can be reached are farther.
        EXPECT_EQ(planner.path().corners().back(), (Cell{5, 3})) << to_string(method);
        const Cell near = planner.path().corners().back();
        EXPECT_EQ(wrong_with(planner.map(), q.start, near, a.length, planner.path().corners()), "");
    }
}

TEST(GridPlanner, StopsAtTheBoundOfItsWork) {
    GridPlanner planner(rooms_map(90, 90, 7, 3));
    planner.prepare();
    core::Rng rng(4);
    int cut = 0;
    for (int i = 0; i < 200; ++i) {
        for (const GridMethod method :
             {GridMethod::kAStar, GridMethod::kJumpPoints, GridMethod::kSubgoals}) {
            GridQuery q =
                from_to(any_passable(planner.map(), rng), any_passable(planner.map(), rng));
            q.max_work = 1 + rng.below(30);
            const GridAnswer a = planner.plan(q, method);
            if (a.outcome == PathOutcome::kUnreachable) {
                continue;
            }
            ASSERT_LE(a.work, q.max_work);
            const Cell end = planner.path().corners().back();
            ASSERT_EQ(wrong_with(planner.map(), q.start, end, a.length, planner.path().corners()),
                      "");
            cut += a.outcome == PathOutcome::kCutOff ? 1 : 0;
            ASSERT_EQ(a.outcome == PathOutcome::kFound, end == q.goal);
        }
    }
    EXPECT_GT(cut, 100);
}

TEST(WeightedAStar, KeepsItsBoundAndLooksAtLess) {
    core::Rng rng(5);
    std::uint64_t work = 0;
    std::uint64_t exact_work = 0;
    for (std::uint64_t seed = 1; seed <= 10; ++seed) {
        GridPlanner planner(rooms_map(120, 90, 9, seed));
        for (int i = 0; i < 40; ++i) {
            GridQuery q =
                from_to(any_passable(planner.map(), rng), any_passable(planner.map(), rng));
            const GridAnswer best = planner.plan(q, GridMethod::kAStar);
            if (best.outcome != PathOutcome::kFound) {
                continue;
            }
            exact_work += best.work;
            q.weight = 1.0F + rng.range(0.0F, 2.0F);
            const GridAnswer a = planner.plan(q, GridMethod::kWeightedAStar);
            work += a.work;
            ASSERT_LE(a.length, best.length * (static_cast<double>(q.weight) + 1.0 / 512) + 1e-6);
            ASSERT_EQ(
                wrong_with(planner.map(), q.start, q.goal, a.length, planner.path().corners()), "");
        }
    }
    EXPECT_LT(work, exact_work / 2);
}

TEST(GridPlanner, AllocatesNothingOnceWarm) {
    GridPlanner planner(rooms_map(128, 128, 8, 2));
    planner.prepare();
    core::Rng rng(6);
    const auto ask = [&](int times) {
        for (int i = 0; i < times; ++i) {
            const GridQuery q =
                from_to(any_passable(planner.map(), rng), any_passable(planner.map(), rng));
            for (const GridMethod method : kExact) {
                planner.plan(q, method);
            }
        }
    };
    ask(1);
    const std::uint64_t before = allocation_count();
    ask(500);
    EXPECT_EQ(allocation_count(), before);
}

TEST(GridPlanner, LeavesOutWhatExceedsItsBounds) {
    IndexBounds bounds;
    GridPlanner planner(random_map(60, 60, 0.2F, 9));
    bounds.labels.labels = 100;
    planner.prepare(bounds);
    EXPECT_FALSE(planner.can(GridMethod::kHubLabels));
    EXPECT_EQ(planner.choice(), GridMethod::kSubgoals);
    bounds.doors = 100;
    planner.prepare(bounds);
    EXPECT_FALSE(planner.can(GridMethod::kSubgoals));
    EXPECT_EQ(planner.choice(), GridMethod::kJumpPoints);
    core::Rng rng(7);
    expect_exact(planner, rng, 30, "no index");
}

TEST(Components, JoinExactlyWhatReachesEachOther) {
    for (std::uint64_t seed = 1; seed <= 40; ++seed) {
        const GridMap map = random_map(33, 21, 0.42F, seed);
        Components components;
        components.label(map);
        core::Rng rng(seed);
        const Cell start = any_passable(map, rng);
        const std::vector<double> lengths = all_lengths(map, start);
        for (std::uint16_t y = 0; y < 21; ++y) {
            for (std::uint16_t x = 0; x < 33; ++x) {
                const std::uint32_t c = components.of(map.place({x, y}));
                ASSERT_EQ(c == 0, !map.passable(Cell{x, y}));
                ASSERT_EQ(c == components.of(map.place(start)),
                          length_to(map, lengths, {x, y}) != kNoPath);
            }
        }
    }
}

TEST(Octile, IsTheBestCostOnAnEmptyMapAndConsistent) {
    const GridMap map = random_map(40, 30, 0.0F, 1);
    const std::vector<double> lengths = all_lengths(map, {7, 11});
    for (int y = 0; y < 30; ++y) {
        for (int x = 0; x < 40; ++x) {
            const Cost h = octile(x - 7, y - 11);
            const Cell c{static_cast<std::uint16_t>(x), static_cast<std::uint16_t>(y)};
            ASSERT_NEAR(h / double{kStraight}, length_to(map, lengths, c), kCostError);
            for (int dy = -1; dy <= 1; ++dy) {
                for (int dx = -1; dx <= 1; ++dx) {
                    const Cost step = dx != 0 && dy != 0 ? kDiagonal : kStraight;
                    ASSERT_LE(h, octile(x + dx - 7, y + dy - 11) + step);
                }
            }
        }
    }
}

TEST(WrongWith, FindsWaysThatCutCornersLeapOrLie) {
    const GridMap map = map_of({"...", ".#.", "..."});
    const std::vector<Cell> round{{0, 0}, {2, 0}, {2, 2}};
    EXPECT_EQ(wrong_with(map, {0, 0}, {2, 2}, 4.0, round), "");
    EXPECT_NE(wrong_with(map, {0, 0}, {2, 2}, 3.9, round), "");
    EXPECT_NE(wrong_with(map, {0, 0}, {2, 1}, 4.0, round), "");
    const std::vector<Cell> cut{{0, 1}, {1, 0}};
    EXPECT_NE(wrong_with(map, {0, 1}, {1, 0}, 1.4142135623731, cut), "");
    const std::vector<Cell> through{{0, 1}, {2, 1}};
    EXPECT_NE(wrong_with(map, {0, 1}, {2, 1}, 2.0, through), "");
    const std::vector<Cell> leap{{0, 0}, {2, 1}};
    EXPECT_NE(wrong_with(map, {0, 0}, {2, 1}, 2.2, leap), "");
}

}  // namespace

}  // namespace zoned::ai::pathfinding
