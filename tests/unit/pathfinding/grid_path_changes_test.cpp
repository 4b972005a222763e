#include "server/ai/pathfinding/grid/line_of_sight.h"
#include "server/ai/pathfinding/requests/grid_path_requests.h"
#include "tests/unit/pathfinding/grid_reference.h"
#include "shared/core/rng.h"

#include <gmock/gmock.h>

#include <cmath>

namespace zoned::ai::pathfinding {

namespace {

/// Cells of a metre with their corner at the origin.
GroundMap metre_ground(const GridMap& cells) {
    const GroundRect area{
        0.0F, 0.0F, static_cast<float>(cells.width()), static_cast<float>(cells.height())};
    return {GroundGrid(area, 1.0F), cells, std::vector<float>(cells.places(), 0.0F)};
}

Cell some_passable(const GridMap& map, core::Rng& rng) {
    while (true) {
        const Cell c{
            static_cast<std::uint16_t>(rng.below(static_cast<std::uint32_t>(map.width()))),
            static_cast<std::uint16_t>(rng.below(static_cast<std::uint32_t>(map.height())))};
        if (map.passable(c)) {
            return c;
        }
    }
}

struct Walker {
    Cell start;
    Cell goal;
    PathRequestId ticket;
    std::vector<Spot> corners;
};

/// Askers on a map, all answered.
class Askers {
  public:
    Askers(const GridMap& map, std::uint32_t count, core::Rng& rng) : service(metre_ground(map)) {
        for (std::uint32_t i = 0; i < count; ++i) {
            Walker w{some_passable(map, rng), some_passable(map, rng), {}, {}};
            w.ticket =
                service.ask({i, service.grid().centre(w.start), service.grid().centre(w.goal)});
            walkers.push_back(w);
        }
        settle();
        load();
    }

    void settle() {
        for (int i = 0; i < 200 && service.counts().waiting != 0; ++i) {
            service.serve();
        }
        ASSERT_EQ(service.counts().waiting, 0U);
    }

    void load() {
        for (Walker& w : walkers) {
            const auto corners = service.answer(w.ticket).corners;
            w.corners.assign(corners.begin(), corners.end());
        }
    }

    /// Whether every segment of the remembered path is free on the present map.
    bool free(const Walker& w) const {
        Cell at = w.start;
        std::uint32_t looked = 0;
        for (const Spot& corner : w.corners) {
            const Cell to = service.grid().cell(corner);
            if (!sees(service.planner().map(), at, to, looked)) {
                return false;
            }
            at = to;
        }
        return true;
    }

    GridPathRequests service;
    std::vector<Walker> walkers;
};

std::vector<CellChange> line_of_cells(const GridMap& map, core::Rng& rng, bool passable) {
    std::vector<CellChange> changes;
    const Cell first{
        static_cast<std::uint16_t>(rng.below(static_cast<std::uint32_t>(map.width()) - 6)),
        static_cast<std::uint16_t>(rng.below(static_cast<std::uint32_t>(map.height()) - 6))};
    const bool across = rng.below(2) == 0;
    for (std::uint16_t i = 0; i < 5; ++i) {
        const Cell c{static_cast<std::uint16_t>(first.x + (across ? i : 0)),
                     static_cast<std::uint16_t>(first.y + (across ? 0 : i))};
        changes.push_back({c, passable});
    }
    return changes;
}

TEST(GridPathChanges, RenewExactlyTheWaysThatAreCut) {
    core::Rng rng(31);
    std::size_t cut = 0;
    for (std::uint64_t seed = 1; seed <= 6; ++seed) {
        Askers a(rooms_map(120, 100, 11, seed), 300, rng);
        for (int round = 0; round < 8; ++round) {
            const auto changes = line_of_cells(a.service.planner().map(), rng, false);
            const std::uint64_t before = a.service.counts().broken;
            a.service.change(changes);
            std::size_t broken = 0;
            for (const Walker& w : a.walkers) {
                const bool still_free = a.free(w);
                broken += still_free ? 0U : 1U;
                ASSERT_EQ(a.service.answer(w.ticket).waiting, !still_free);
            }
            ASSERT_EQ(a.service.counts().broken - before, broken);
            cut += broken;
            std::vector<std::vector<Spot>> old;
            for (const Walker& w : a.walkers) {
                old.push_back(a.free(w) ? w.corners : std::vector<Spot>());
            }
            a.settle();
            a.load();
            GridPlanner anew(a.service.planner().map());
            for (std::size_t i = 0; i < a.walkers.size(); ++i) {
                Walker& w = a.walkers[i];
                if (!old[i].empty()) {
                    ASSERT_EQ(w.corners, old[i]);  // the rest untouched
                } else if (anew.map().passable(w.start) && anew.map().passable(w.goal)) {
                    GridQuery q;
                    q.start = w.start;
                    q.goal = w.goal;
                    const GridAnswer best = anew.plan(q);
                    const PathResult answer = a.service.answer(w.ticket);
                    ASSERT_EQ(answer.outcome == PathOutcome::kFound,
                              best.outcome == PathOutcome::kFound);
                    ASSERT_TRUE(a.free(w));
                    if (best.outcome == PathOutcome::kFound) {
                        ASSERT_LE(answer.length_m, best.length + 0.01);
                    }
                }
            }
            // Requesters whose place or goal is blocked now ask from elsewhere.
            std::erase_if(a.walkers, [&](const Walker& w) {
                const bool gone = !anew.map().passable(w.start) || !anew.map().passable(w.goal);
                if (gone) {
                    a.service.release(w.ticket);
                }
                return gone;
            });
        }
    }
    EXPECT_GT(cut, 100U);
}

TEST(GridPathChanges, FindShortCutsThatAreOpenedAndKeepTheOldWayUntilThen) {
    core::Rng rng(32);
    std::size_t shorter = 0;
    for (std::uint64_t seed = 1; seed <= 6; ++seed) {
        Askers a(rooms_map(120, 100, 11, seed), 200, rng);
        for (int round = 0; round < 8; ++round) {
            std::vector<float> length;
            for (const Walker& w : a.walkers) {
                length.push_back(a.service.answer(w.ticket).length_m);
            }
            a.service.change(line_of_cells(a.service.planner().map(), rng, true));
            for (const Walker& w : a.walkers) {
                const PathResult answer = a.service.answer(w.ticket);
                if (answer.outcome == PathOutcome::kFound) {
                    ASSERT_FALSE(answer.waiting);
                    ASSERT_TRUE(std::equal(answer.corners.begin(),
                                           answer.corners.end(),
                                           w.corners.begin(),
                                           w.corners.end()));
                }
            }
            a.settle();
            a.load();
            GridPlanner anew(a.service.planner().map());
            for (std::size_t i = 0; i < a.walkers.size(); ++i) {
                GridQuery q;
                q.start = a.walkers[i].start;
                q.goal = a.walkers[i].goal;
                const GridAnswer best = anew.plan(q);
                const PathResult answer = a.service.answer(a.walkers[i].ticket);
                if (best.outcome == PathOutcome::kFound) {
                    ASSERT_EQ(answer.outcome, PathOutcome::kFound);
                    ASSERT_LE(answer.length_m, best.length + 0.01);
                    shorter += answer.length_m < length[i] - 0.01F ? 1U : 0U;
                }
            }
        }
    }
    EXPECT_GT(shorter, 50U);
}

TEST(GridPathChanges, LookAgainForWhoWasOutOfReachOnlyWhereThatMayBeOtherwise) {
    core::Rng rng(37);
    std::size_t out_of_reach = 0;
    std::size_t left_alone = 0;
    std::size_t nearer = 0;
    for (std::uint64_t seed = 1; seed <= 6; ++seed) {
        // Of scattered obstacles two fifths: many pockets.
        Askers a(random_map(90, 80, 0.4F, seed), 300, rng);
        for (int round = 0; round < 25; ++round) {
            std::vector<CellChange> changes =
                line_of_cells(a.service.planner().map(), rng, round % 3 != 0);
            const auto more = line_of_cells(a.service.planner().map(), rng, rng.below(2) != 0);
            changes.insert(changes.end(), more.begin(), more.begin() + 1);
            std::vector<float> off;
            const auto off_goal = [&a](const Walker& w) {
                const Spot goal = a.service.grid().centre(w.goal);
                const Spot end =
                    w.corners.empty() ? a.service.grid().centre(w.start) : w.corners.back();
                return std::hypot(goal.x - end.x, goal.z - end.z);
            };
            for (const Walker& w : a.walkers) {
                off.push_back(off_goal(w));
            }
            a.service.change(changes);
            std::vector<bool> alone;
            for (const Walker& w : a.walkers) {
                const auto again = a.service.requeued();
                alone.push_back(std::find(again.begin(), again.end(), w.ticket.slot) ==
                                again.end());
            }
            a.settle();
            a.load();
            GridPlanner anew(a.service.planner().map());
            for (std::size_t i = 0; i < a.walkers.size(); ++i) {
                const Walker& w = a.walkers[i];
                const PathResult answer = a.service.answer(w.ticket);
                if (!anew.map().passable(w.start) || !anew.map().passable(w.goal)) {
                    continue;
                }
                GridQuery q;
                q.start = w.start;
                q.goal = w.goal;
                q.nearest = true;
                const GridAnswer best = anew.plan(q);
                ASSERT_EQ(answer.outcome, best.outcome) << seed << " round " << round;
                ASSERT_TRUE(a.free(w));
                if (best.outcome != PathOutcome::kPartial) {
                    continue;
                }
                ++out_of_reach;
                left_alone += alone[i] ? 1U : 0U;
                nearer += off_goal(w) < off[i] ? 1U : 0U;
                const Cell end =
                    w.corners.empty() ? w.start : a.service.grid().cell(w.corners.back());
                const Cell wanted = anew.path().corners().back();
                ASSERT_EQ(octile(end.x - w.goal.x, end.y - w.goal.y),
                          octile(wanted.x - w.goal.x, wanted.y - w.goal.y));
                ASSERT_LE(answer.length_m, best.length + 0.01);
            }
        }
    }
    EXPECT_GT(out_of_reach, 5000U);
    EXPECT_GT(left_alone, out_of_reach / 2);
    EXPECT_GT(nearer, 20U);
}

TEST(GridPathChanges, AnswerExactlyWhileTheIndexIsRenewedOverTicks) {
    core::Rng rng(33);
    const GridMap map = rooms_map(200, 180, 11, 5);
    GridPathSettings settings;
    settings.index_work_per_tick = 100'000;
    GridPathRequests service(metre_ground(map), settings);
    EXPECT_EQ(service.planner().choice(), GridMethod::kHubLabels);
    const CellChange door{some_passable(map, rng), false};
    service.change(std::span(&door, 1));
    EXPECT_FALSE(service.indexed());
    EXPECT_EQ(service.planner().choice(), GridMethod::kJumpPoints);
    int ticks = 0;
    GridPlanner anew(service.planner().map());
    std::vector<GridMethod> choices;
    for (; !service.indexed() && ticks < 1000; ++ticks) {
        const Cell start = some_passable(anew.map(), rng);
        const Cell goal = some_passable(anew.map(), rng);
        const PathRequestId t =
            service.ask({0, service.grid().centre(start), service.grid().centre(goal)});
        service.serve();
        GridQuery q;
        q.start = start;
        q.goal = goal;
        const GridAnswer best = anew.plan(q);
        const PathResult answer = service.answer(t);
        ASSERT_FALSE(answer.waiting);
        ASSERT_TRUE(best.outcome != PathOutcome::kFound || answer.length_m <= best.length + 0.01);
        service.release(t);
        choices.push_back(service.planner().choice());
    }
    EXPECT_GT(ticks, 5);
    EXPECT_LT(ticks, 1000);
    EXPECT_THAT(choices, testing::Contains(GridMethod::kSubgoals));
    EXPECT_EQ(service.planner().choice(), GridMethod::kHubLabels);
    // The index equals one that is built anew.
    anew.prepare();
    EXPECT_EQ(service.planner().index_bytes(), anew.index_bytes());
    // Changes without effect cost nothing.
    service.change(std::span(&door, 1));
    EXPECT_TRUE(service.indexed());
}

TEST(GridPathChanges, LeadWhoHasWalkedWhileWaitingFromWhereItIs) {
    core::Rng rng(34);
    const GridMap map = rooms_map(120, 100, 11, 3);
    GridPathSettings settings;
    settings.work_per_tick = 1;
    settings.longest_wait_ticks = 40;
    GridPathRequests service(metre_ground(map), settings);
    std::vector<Spot> at;
    std::vector<PathRequestId> tickets;
    for (std::uint32_t i = 0; i < 60; ++i) {
        at.push_back(service.grid().centre(some_passable(map, rng)));
        const Spot to = service.grid().centre(some_passable(map, rng));
        tickets.push_back(service.ask({i, at.back(), to}));
    }
    int walked = 0;
    std::vector<bool> answered(at.size(), false);
    for (int tick = 0; service.counts().waiting != 0 && tick < 100; ++tick) {
        service.serve();
        for (std::size_t i = 0; i < at.size(); ++i) {
            const PathResult answer = service.answer(tickets[i]);
            if (answered[i]) {
                continue;
            }
            if (answer.waiting) {
                const Spot head = service.heading(tickets[i], at[i], 0.3F);
                const float off = std::max(std::hypot(head.x - at[i].x, head.z - at[i].z), 1e-6F);
                const float share = std::min(1.0F, 0.25F / off);
                at[i] = {at[i].x + share * (head.x - at[i].x),
                         at[i].z + share * (head.z - at[i].z)};
                service.heading(tickets[i], at[i], 0.3F);  // reports its present place
                continue;
            }
            answered[i] = true;
            std::uint32_t looked = 0;
            const Cell from = service.grid().cell(at[i]);
            if (answer.outcome == PathOutcome::kFound && map.passable(from)) {
                walked += tick > 4 ? 1 : 0;
                EXPECT_TRUE(sees(map, from, service.grid().cell(answer.corners.front()), looked));
            }
        }
    }
    EXPECT_GT(walked, 30);
}

TEST(GridPathChanges, TakeNoMoreWorkInATickThanItWasGiven) {
    core::Rng rng(35);
    const GridMap map = rooms_map(300, 280, 11, 2);
    GridPathRequests service(metre_ground(map));
    const GridPathSettings settings;
    for (std::uint32_t i = 0; i < 600; ++i) {
        service.ask({i,
                     service.grid().centre(some_passable(map, rng)),
                     service.grid().centre(some_passable(map, rng))});
    }
    std::uint64_t most = 0;
    std::uint64_t index = 0;
    std::uint64_t ticks = 0;
    const auto serve = [&] {
        service.serve();
        most = std::max(most, service.counts().work);
        index += service.counts().index_work;
        ++ticks;
    };
    while (service.counts().waiting != 0) {
        serve();
    }
    // Doors on the paths of many, some before the index of the last is there.
    for (int round = 0; round < 40; ++round) {
        service.change(line_of_cells(service.planner().map(), rng, round % 3 == 0));
        for (int tick = 0; tick < round % 12; ++tick) {
            serve();
        }
    }
    while (service.counts().waiting != 0 || !service.indexed()) {
        serve();
    }
    EXPECT_GT(service.counts().broken, 100U);
    // Beyond it, the work of the last request begun counts: at most two units for each cell around
    // an unreachable goal, and some ten thousand for a table and a path. Thirty are due in a tick:
    // their need is less than all.
    EXPECT_LE(most, settings.work_per_tick + 2U * 300U * 280U + 50'000U);
    EXPECT_GT(most, settings.work_per_tick / 2);
    // Besides, one part of the index may be begun beyond its share.
    EXPECT_LE(index, ticks * settings.index_work_per_tick + 100'000);
    EXPECT_LE(service.counts().longest_wait_ticks, settings.longest_wait_ticks);
}

TEST(GridPathChanges, GiveBackTheCornersOfWaysThatTheyRenew) {
    core::Rng rng(36);
    Askers a(rooms_map(120, 100, 11, 4), 300, rng);
    std::vector<CellChange> door;
    for (int i = 0; i < 100; ++i) {
        const auto line = line_of_cells(a.service.planner().map(), rng, false);
        door.insert(door.end(), line.begin(), line.end());
    }
    std::erase_if(door,
                  [&](const CellChange& c) { return !a.service.planner().map().passable(c.cell); });
    const auto turn = [&](int rounds) {
        for (int round = 0; round < 2 * rounds; ++round) {
            for (CellChange& c : door) {
                c.passable = round % 2 != 0;
            }
            a.service.change(door);
            a.settle();
        }
        while (!a.service.indexed()) {
            a.service.serve();
        }
        return a.service.bytes();
    };
    // Each turn most of 300 paths get another some 30 corners long: 70 KB, which would be 4 MB.
    // The remainder is that paths differ in length: the pool has not seen as many of each at first.
    const std::size_t before = turn(5);
    EXPECT_LE(turn(30), before + before / 2);
}

}  // namespace

}  // namespace zoned::ai::pathfinding
