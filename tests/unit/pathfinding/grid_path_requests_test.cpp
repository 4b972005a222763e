#include "server/ai/pathfinding/requests/grid_path_requests.h"

#include "server/ai/pathfinding/grid/line_of_sight.h"
#include "server/ai/pathfinding/grid/work_units.h"
#include "tests/unit/allocation_count.h"
#include "tests/unit/pathfinding/grid_reference.h"
#include "shared/core/rng.h"

#include <gmock/gmock.h>

#include <cmath>

namespace zoned::ai::pathfinding {

namespace {

constexpr float kRequestCell_m = 0.5F;

/// A map of cells as a ground whose corner is the origin.
GroundMap ground_of(const GridMap& cells) {
    const GroundRect area{0.0F,
                          0.0F,
                          kRequestCell_m * static_cast<float>(cells.width()),
                          kRequestCell_m * static_cast<float>(cells.height())};
    return {GroundGrid(area, kRequestCell_m), cells, std::vector<float>(cells.places(), 0.0F)};
}

Spot any_spot(const GridMap& map, core::Rng& rng) {
    return {kRequestCell_m * static_cast<float>(map.width()) * rng.unit(),
            kRequestCell_m * static_cast<float>(map.height()) * rng.unit()};
}

Spot any_free_spot(const GridPathRequests& service, core::Rng& rng) {
    while (true) {
        const Spot s = any_spot(service.planner().map(), rng);
        if (service.planner().map().passable(service.grid().cell(s))) {
            return s;
        }
    }
}

TEST(RequestTurns, TakesAskersInTurnAndEachOnesRequestsInOrder) {
    RequestTurns queue(10);
    queue.push(0, 7);
    queue.push(1, 7);
    queue.push(2, 7);
    queue.push(3, 4);
    queue.push(4, 2);
    std::vector<std::uint32_t> order;
    while (!queue.empty()) {
        order.push_back(queue.front());
        queue.pop();
    }
    EXPECT_THAT(order, testing::ElementsAre(0, 3, 4, 1, 2));
}

TEST(RequestTurns, RequiresOfEachTickWhatKeepsEveryoneInTime) {
    core::Rng rng(3);
    constexpr std::uint32_t kWait = 7;
    RequestTurns queue(kWait);
    std::uint32_t number = 0;
    std::uint32_t longest = 0;
    std::uint32_t most = 0;
    for (int tick = 0; tick < 500; ++tick) {
        const std::uint32_t come = rng.below(10) == 0 ? 300 : rng.below(5);
        for (std::uint32_t i = 0; i < come; ++i, ++number) {
            queue.push(number, number);
        }
        const std::uint32_t required = queue.required();
        most = std::max(most, required);
        for (std::uint32_t i = 0; i < required; ++i) {
            longest = std::max(longest, queue.waited());
            queue.pop();
        }
        queue.tick();
    }
    EXPECT_LE(longest, kWait);
    // Bursts are shared out over the ticks until they are due, not served in the last of them.
    EXPECT_LT(most, 300U);
}

/// Serves all requests within `ticks`; fails the test where some still wait.
void serve_all(GridPathRequests& service, int ticks) {
    for (int i = 0; i < ticks && service.counts().waiting != 0; ++i) {
        service.serve();
    }
    ASSERT_EQ(service.counts().waiting, 0U);
}

TEST(GridPathRequests, AnswersWithFreeCornersFromTheStartToTheGoal) {
    core::Rng rng(4);
    for (std::uint64_t seed = 1; seed <= 12; ++seed) {
        const GridMap cells =
            seed % 2 == 0 ? rooms_map(90, 80, 9, seed) : random_map(90, 80, 0.3F, seed);
        GridPathRequests service(ground_of(cells));
        GridPlanner planner(cells);
        for (int i = 0; i < 60; ++i) {
            const Spot from = any_free_spot(service, rng);
            const Spot to = any_free_spot(service, rng);
            const PathRequestId ticket = service.ask({0, from, to});
            ASSERT_TRUE(service.answer(ticket).waiting);
            serve_all(service, 3);
            const PathResult a = service.answer(ticket);
            GridQuery q;
            q.start = service.grid().cell(from);
            q.goal = service.grid().cell(to);
            const GridAnswer best = planner.plan(q);
            ASSERT_EQ(a.outcome == PathOutcome::kFound, best.outcome == PathOutcome::kFound);
            ASSERT_EQ(a.outcome == PathOutcome::kPartial,
                      best.outcome == PathOutcome::kUnreachable);
            Cell at = q.start;
            std::uint32_t looked = 0;
            for (const Spot& corner : a.corners) {
                ASSERT_TRUE(sees(cells, at, service.grid().cell(corner), looked));
                at = service.grid().cell(corner);
            }
            if (a.outcome == PathOutcome::kFound) {
                EXPECT_EQ(a.corners.back(), to);
                // Ends lie off the middles of their cells by half a diagonal at most.
                EXPECT_LE(a.length_m, kRequestCell_m * (best.length + 2.0 * 0.7072) + 1e-3);
            }
            service.release(ticket);
        }
    }
}

/// Length of the paths of a hundred requests, m.
double total_length(GridPathRequests& service) {
    core::Rng rng(4);
    double sum = 0.0;
    for (int i = 0; i < 100; ++i) {
        const Spot from = any_free_spot(service, rng);
        const PathRequestId ticket = service.ask({0, from, any_free_spot(service, rng)});
        service.serve();
        const PathResult found = service.answer(ticket);
        EXPECT_FALSE(found.waiting);
        sum += static_cast<double>(found.length_m);
        service.release(ticket);
    }
    return sum;
}

/// Asks for one path between any two places, and serves.
PathResult ask_any(GridPathRequests& service, core::Rng& rng) {
    const Spot from = any_free_spot(service, rng);
    const PathRequestId ticket = service.ask({0, from, any_free_spot(service, rng)});
    service.serve();
    return service.answer(ticket);
}

/// Searches without an index pay for it: it is not there before, and soon after.
TEST(GridPathIndex, IsMadeOnceSearchesHaveCostAsMuch) {
    core::Rng rng(8);
    const GridMap map = rooms_map(90, 80, 9, 3);
    GridPathSettings settings;
    settings.index_at_start = 0;
    GridPathRequests service(ground_of(map), settings);
    const std::uint64_t price = kIndexUnits * map.places();
    std::uint64_t paid = 0;
    int ticks = 0;
    for (; service.indexed() && ticks < 2000; ++ticks) {
        EXPECT_EQ(service.planner().choice(), GridMethod::kJumpPoints);
        ask_any(service, rng);
        paid += service.counts().work;
    }
    EXPECT_GT(paid, price) << "after " << ticks;
    EXPECT_LT(paid, 4 * price) << "searches are the greater part of the work";
    for (int more = 0; !service.indexed() && more < 100; ++more) {
        service.serve();
    }
    EXPECT_EQ(service.planner().choice(), GridMethod::kHubLabels);
    // Straight paths need none.
    GridMap open(90, 80);
    for (std::uint16_t y = 0; y < 80; ++y) {
        for (std::uint16_t x = 0; x < 90; ++x) {
            open.set_passable({x, y}, true);
        }
    }
    GridPathRequests plain(ground_of(open), settings);
    for (int i = 0; i < 2 * ticks; ++i) {
        ask_any(plain, rng);
    }
    EXPECT_EQ(plain.counts().straight, static_cast<std::uint64_t>(2 * ticks));
    EXPECT_TRUE(plain.indexed());
    EXPECT_EQ(plain.planner().index_bytes(), 0U);
}

TEST(GridPathIndex, GoesOnInTheSameTickInACopyMadeInAny) {
    core::Rng rng(9);
    const GridMap map = rooms_map(90, 80, 9, 3);
    GridPathSettings settings;
    settings.index_at_start = 0;
    settings.index_work_per_tick = 30'000;
    settings.work_per_tick = 40'000;
    GridPathRequests straight(ground_of(map), settings);
    auto copied = std::make_unique<GridPathRequests>(ground_of(map), settings);
    int building = 0;
    for (int tick = 0; tick < 1000 && straight.planner().choice() != GridMethod::kHubLabels;
         ++tick) {
        core::Rng same = rng;
        const PathResult one = ask_any(straight, rng);
        const PathResult other = ask_any(*copied, same);
        ASSERT_EQ(other.waiting, one.waiting);
        ASSERT_EQ(other.length_m, one.length_m);
        ASSERT_TRUE(std::equal(
            other.corners.begin(), other.corners.end(), one.corners.begin(), one.corners.end()));
        ASSERT_EQ(copied->indexed(), straight.indexed()) << "tick " << tick;
        ASSERT_EQ(copied->planner().choice(), straight.planner().choice()) << "tick " << tick;
        ASSERT_EQ(copied->counts().index_work, straight.counts().index_work) << "tick " << tick;
        building += straight.indexed() ? 0 : 1;
        const SavedPaths saved = copied->save();
        EXPECT_TRUE(saved.whole);
        copied = std::make_unique<GridPathRequests>(ground_of(map), settings);
        ASSERT_EQ(copied->load(saved), "");
    }
    EXPECT_EQ(straight.planner().choice(), GridMethod::kHubLabels);
    EXPECT_GT(building, 5) << "copies were made while the index was";
}

/// Paths from A* and jump points are as short as those of the index, up to what taut ends of the
/// same cost differ by; a weight makes some longer, none by more than it. Only the search that
/// suits the map has an index.
TEST(GridPathSearch, IsTheOneThatTheSettingsName) {
    const auto with = [](GridSearch search) {
        GridPathSettings settings;
        settings.search = search;
        return std::make_unique<GridPathRequests>(ground_of(rooms_map(90, 80, 9, 3)), settings);
    };
    const auto indexed = with({});
    const double best = total_length(*indexed);
    EXPECT_GT(indexed->planner().index_bytes(), 0U);
    for (const GridMethod method : {GridMethod::kAStar, GridMethod::kJumpPoints}) {
        const auto named = with({method, 1.0F});
        EXPECT_EQ(named->planner().choice(), method);
        EXPECT_EQ(named->planner().index_bytes(), 0U);
        EXPECT_NEAR(total_length(*named), best, 0.02 * best) << to_string(method);
    }
    const auto greedy = with({GridMethod::kWeightedAStar, 3.0F});
    const double longer = total_length(*greedy);
    EXPECT_GT(longer, 1.005 * best);
    EXPECT_LT(longer, 3.0 * best);
}

TEST(GridPathRequests, NamesWhatCantBeAnswered) {
    GridMap cells = map_of({"....#.................",
                            "....#.................",
                            "....#.................",
                            "....#.................",
                            "....#.................",
                            "....#.................",
                            "....#.................",
                            "....#.................",
                            "....#................#",
                            "....#...............##"});
    GridPathSettings settings;
    settings.reach_cells = 1;
    GridPathRequests service(ground_of(cells), settings);
    const auto outcome = [&](Spot from, Spot to) {
        const PathRequestId t = service.ask({0, from, to});
        service.serve();
        const PathResult a = service.answer(t);
        EXPECT_FALSE(a.waiting);
        return a.outcome;
    };
    EXPECT_EQ(outcome({0.2F, 0.2F}, {1.7F, 4.7F}), PathOutcome::kFound);
    EXPECT_EQ(outcome({-0.2F, 0.2F}, {1.7F, 4.7F}), PathOutcome::kOffMap);
    EXPECT_EQ(outcome({0.2F, 0.2F}, {1e30F, 4.7F}), PathOutcome::kOffMap);
    EXPECT_EQ(outcome({std::nanf(""), 0.2F}, {1.7F, 4.7F}), PathOutcome::kOffMap);
    EXPECT_EQ(outcome({0.2F, 0.2F}, {5.2F, 0.2F}), PathOutcome::kPartial);  // beyond the wall
    EXPECT_EQ(outcome({2.2F, 2.2F}, {1.7F, 4.7F}), PathOutcome::kFound);    // pressed into the wall
    EXPECT_EQ(outcome({5.2F, 0.2F}, {10.6F, 4.3F}), PathOutcome::kPartial);  // in the wall
    settings.reach_cells = 0;
    GridPathRequests strict(ground_of(cells), settings);
    PathRequestId t = strict.ask({0, {2.3F, 2.2F}, {1.7F, 4.7F}});
    EXPECT_EQ(strict.answer(t).outcome, PathOutcome::kStartBlocked);
    t = strict.ask({0, {1.7F, 4.7F}, {2.3F, 2.2F}});
    EXPECT_EQ(strict.answer(t).outcome, PathOutcome::kGoalBlocked);
}

/// The requesters, and how all have been answered: a fingerprint, and the longest wait.
struct Load {
    std::uint64_t fingerprint = 1469598103934665603U;
    std::uint32_t longest = 0;
    std::uint64_t most_work = 0;
    std::uint64_t by_regions = 0;
    std::uint64_t fields = 0;
    std::size_t wrong = 0;
};

Load ask_many(GridPathRequests& service,
              std::uint32_t askers,
              std::uint32_t goals,
              std::uint64_t seed) {
    core::Rng rng(seed);
    Load load;
    std::vector<Spot> to;
    for (std::uint32_t i = 0; i < goals; ++i) {
        to.push_back(any_free_spot(service, rng));
    }
    std::vector<PathRequestId> tickets;
    for (std::uint32_t i = 0; i < askers; ++i) {
        tickets.push_back(service.ask({i, any_free_spot(service, rng), to[rng.below(goals)]}));
    }
    for (int tick = 0; tick < 1000 && service.counts().waiting != 0; ++tick) {
        service.serve();
        load.most_work = std::max(load.most_work, service.counts().work);
    }
    for (const PathRequestId t : tickets) {
        const PathResult a = service.answer(t);
        load.wrong += a.waiting || a.outcome != PathOutcome::kFound ? 1U : 0U;
        for (const Spot& s : a.corners) {
            for (const float v : {s.x, s.z}) {
                load.fingerprint =
                    (load.fingerprint ^ std::bit_cast<std::uint32_t>(v)) * 1099511628211U;
            }
        }
        service.release(t);
    }
    load.longest = service.counts().longest_wait_ticks;
    load.by_regions = service.counts().by_regions;
    load.fields = service.counts().fields;
    return load;
}

GridMap joined_rooms() {
    // Only cells that reach each other, so that every path is found.
    GridMap map = rooms_map(200, 180, 11, 5);
    Components components;
    components.label(map);
    std::vector<std::uint32_t> size(map.places() + std::size_t{1}, 0);
    for (Place p = 0; p < map.places(); ++p) {
        ++size[components.of(p)];
    }
    size[0] = 0;
    const auto most =
        static_cast<std::uint32_t>(std::max_element(size.begin(), size.end()) - size.begin());
    for (Place p = map.stride() * 2; p < map.places(); ++p) {
        if (map.passable(p) && components.of(p) != most) {
            map.set_passable(map.cell(p), false);
        }
    }
    return map;
}

TEST(GridPathRequests, KeepsTheBoundOnWaitingWhateverTheLoad) {
    const GroundMap ground = ground_of(joined_rooms());
    GridPathSettings settings;
    settings.longest_wait_ticks = 12;
    for (const std::uint64_t work : {20'000'000U, 1'000'000U, 20'000U}) {
        settings.work_per_tick = work;
        GridPathRequests service(ground, settings);
        const Load load = ask_many(service, 3000, 3000, 1);
        EXPECT_EQ(load.wrong, 0U);
        EXPECT_LE(load.longest, settings.longest_wait_ticks) << work;
        EXPECT_EQ(load.by_regions != 0, work == 20'000U) << work;
    }
}

TEST(GridPathRequests, AnswersAllWithFewerTablesThanGoals) {
    const GroundMap ground = ground_of(joined_rooms());
    GridPathSettings settings;
    settings.longest_wait_ticks = 12;
    settings.work_per_tick = 20'000;  // most go from region to region
    GridPathRequests service(ground, settings);
    const Load whole = ask_many(service, 600, 600, 1);
    settings.tables = 2;
    GridPathRequests small(ground, settings);
    const Load few = ask_many(small, 600, 600, 1);
    EXPECT_GT(few.by_regions, 100U);
    EXPECT_EQ(few.wrong, 0U);
    EXPECT_LE(few.longest, settings.longest_wait_ticks);
    EXPECT_EQ(few.longest, whole.longest);
    // Later the tables of those who no longer wait are replaced.
    const std::size_t most = small.save().tables.size();
    for (int round = 0; round < 30; ++round) {
        EXPECT_EQ(ask_many(small, 3, 3, 7U + static_cast<std::uint64_t>(round)).wrong, 0U);
        for (int tick = 0; tick < 13; ++tick) {
            small.serve();
        }
    }
    EXPECT_LE(small.save().tables.size(), most);
}

TEST(GridPathRequests, SpreadsWorkOverTicksUpToOneRequest) {
    const GroundMap ground = ground_of(joined_rooms());
    GridPathSettings settings;
    settings.work_per_tick = 300'000;
    settings.longest_wait_ticks = 1000;
    GridPathRequests service(ground, settings);
    const Load load = ask_many(service, 3000, 3000, 2);
    EXPECT_EQ(load.wrong, 0U);
    EXPECT_GT(load.longest, 2U);
    // One more request than the work of a tick allows: far below 200,000 visited cells.
    EXPECT_LT(load.most_work, settings.work_per_tick + 200'000U);
}

TEST(GridPathRequests, MakesAFieldForAGoalThatManyShareAndNotForOthers) {
    const GroundMap ground = ground_of(joined_rooms());
    GridPathSettings settings;
    settings.index.doors = 0;  // no index: searches are dear
    settings.work_per_tick = 400'000;
    settings.longest_wait_ticks = 1000;
    GridPathRequests service(ground, settings);
    EXPECT_EQ(ask_many(service, 300, 300, 3).fields, 0U);
    const Load load = ask_many(service, 2000, 1, 4);
    EXPECT_EQ(load.wrong, 0U);
    EXPECT_EQ(load.fields, 1U);
    EXPECT_GT(service.counts().by_field, 1900U - service.counts().straight);
    // As short as by the planner.
    core::Rng rng(5);
    const Spot to = any_free_spot(service, rng);
    std::vector<PathRequestId> tickets;
    std::vector<Spot> from;
    for (std::uint32_t i = 0; i < 2000; ++i) {
        from.push_back(any_free_spot(service, rng));
        tickets.push_back(service.ask({i, from.back(), to}));
    }
    serve_all(service, 1000);
    EXPECT_EQ(service.counts().fields, 2U);
    // Its steps lead to the goal from everywhere; to a goal of nobody's there is none.
    const auto flow = service.flow_to(service.grid().cell(to));
    ASSERT_TRUE(flow);
    for (std::size_t i = 0; i < from.size(); i += 50) {
        Cell at = service.grid().cell(from[i]);
        for (int steps = 0; flow(at) < kArrived && steps < 10000; ++steps) {
            at = hopped(at, flow(at));
        }
        EXPECT_EQ(at, service.grid().cell(to));
    }
    EXPECT_FALSE(service.flow_to(service.grid().cell(from[0])));
    GridPlanner planner(service.planner().map());
    for (std::size_t i = 0; i < tickets.size(); i += 10) {
        GridQuery q;
        q.start = service.grid().cell(from[i]);
        q.goal = service.grid().cell(to);
        EXPECT_LE(service.answer(tickets[i]).length_m,
                  kRequestCell_m * (planner.plan(q).length + 2.0 * 0.7072) + 1e-3);
    }
}

TEST(GridPathRequests, GivesEqualAnswersToEqualCallsAndAllocatesNothingOnceWarm) {
    const GroundMap ground = ground_of(joined_rooms());
    GridPathSettings settings;
    settings.work_per_tick = 100'000;
    GridPathRequests a(ground, settings);
    GridPathRequests b(ground, settings);
    EXPECT_EQ(ask_many(a, 800, 700, 6).fingerprint, ask_many(b, 800, 700, 6).fingerprint);
    EXPECT_NE(ask_many(a, 800, 700, 7).fingerprint, ask_many(b, 800, 700, 8).fingerprint);
    std::vector<PathRequestId> tickets(800);
    core::Rng rng(9);
    const auto round = [&] {
        for (std::uint32_t i = 0; i < tickets.size(); ++i) {
            tickets[i] = a.ask({i, any_free_spot(a, rng), any_free_spot(a, rng)});
        }
        while (a.counts().waiting != 0) {
            a.serve();
            for (const PathRequestId t : tickets) {
                a.heading(t, {10.0F, 10.0F}, 0.3F);
            }
        }
        for (const PathRequestId t : tickets) {
            a.release(t);
        }
    };
    // Paths are of random lengths: the pool has to have seen as many of each.
    for (int i = 0; i < 60; ++i) {
        round();
    }
    const std::uint64_t before = allocation_count();
    round();
    EXPECT_LE(allocation_count() - before, 1U);
}

TEST(GridPathRequests, SendsEachAskerTowardsItsGoalFromTheFirstTick) {
    const GroundMap ground = ground_of(joined_rooms());
    GridPathSettings settings;
    settings.work_per_tick = 1;
    settings.longest_wait_ticks = 1'000'000;
    GridPathRequests service(ground, settings);
    core::Rng rng(12);
    for (std::uint32_t i = 0; i < 300; ++i) {
        const Spot to = any_free_spot(service, rng);
        Spot at = any_free_spot(service, rng);
        const PathRequestId ticket = service.ask({i, at, to});
        // By headings alone, without ever being served, it comes into the goal's area.
        const Cell goal = service.grid().cell(to);
        const GridMap& map = service.planner().map();
        int steps = 0;
        std::uint32_t looked = 0;
        while (!service.regions().together(map, service.grid().cell(at), goal) && steps < 2000) {
            const Spot head = service.heading(ticket, at, 0.3F);
            ASSERT_NE(head, at);
            ASSERT_TRUE(sees(map, service.grid().cell(at), service.grid().cell(head), looked));
            at = head;
            ++steps;
        }
        EXPECT_LT(steps, 2000);
        EXPECT_TRUE(service.answer(ticket).waiting);
    }
}

TEST(GridPathRequests, LeadsFromCornerToCornerToTheGoal) {
    const GroundMap ground = ground_of(joined_rooms());
    GridPathRequests service(ground);
    core::Rng rng(13);
    for (std::uint32_t i = 0; i < 100; ++i) {
        Spot at = any_free_spot(service, rng);
        const Spot to = any_free_spot(service, rng);
        const PathRequestId ticket = service.ask({i, at, to});
        serve_all(service, 5);
        const float length = service.answer(ticket).length_m;
        float walked = 0.0F;
        for (int k = 0; k < 10'000 && std::hypot(at.x - to.x, at.z - to.z) > 0.01F; ++k) {
            const Spot head = service.heading(ticket, at, 0.05F);
            const float off = std::hypot(head.x - at.x, head.z - at.z);
            const float share = std::min(1.0F, 0.1F / off);
            at = {at.x + share * (head.x - at.x), at.z + share * (head.z - at.z)};
            walked += share * off;
        }
        EXPECT_NEAR(at.x, to.x, 0.02F);
        EXPECT_NEAR(at.z, to.z, 0.02F);
        EXPECT_LE(walked, length + 0.2F);
    }
}

TEST(GridPathRequests, KnowsNoTicketThatWasReleasedAndFreesWhatWaits) {
    const GroundMap ground = ground_of(joined_rooms());
    GridPathRequests service(ground);
    core::Rng rng(14);
    const PathRequestId a =
        service.ask({1, any_free_spot(service, rng), any_free_spot(service, rng)});
    const PathRequestId b =
        service.ask({1, any_free_spot(service, rng), any_free_spot(service, rng)});
    service.release(a);
    EXPECT_FALSE(service.knows(a));
    EXPECT_TRUE(service.knows(b));
    service.serve();
    EXPECT_FALSE(service.answer(b).waiting);
    EXPECT_EQ(service.counts().served, 1U);
    const PathRequestId c =
        service.ask({1, any_free_spot(service, rng), any_free_spot(service, rng)});
    EXPECT_EQ(c.slot, a.slot);
    EXPECT_NE(c.round, a.round);
    EXPECT_FALSE(service.knows(a));
}

}  // namespace

}  // namespace zoned::ai::pathfinding
