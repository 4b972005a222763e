// build: computes
#include "server/ai/pathfinding/requests/zone_portals.h"

#include "server/ai/pathfinding/grid_search/grid_planner.h"
#include "server/ai/pathfinding/requests/portal_costs.h"
#include "tests/unit/pathfinding/grid_reference.h"
#include "shared/core/rng.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <string>
#include <utility>

namespace zoned::ai::pathfinding {

namespace {

constexpr float kZoneCell_m = 0.5F;

/// A map cut into zones, each with its origin in its middle, as zones have it. Their maps go beyond
/// them by so many cells, over their neighbours or outside the world.
struct CutMap {
    CutMap(const GridMap& map,
           std::initializer_list<int> lefts,
           std::initializer_list<int> tops,
           int beyond = 0)
        : whole(map),
          margin(beyond) {
        grounds.reserve(lefts.size() * tops.size());
        for (auto top = tops.begin(); top != tops.end(); ++top) {
            for (auto left = lefts.begin(); left != lefts.end(); ++left) {
                const int right = left + 1 == lefts.end() ? map.width() : left[1];
                const int bottom = top + 1 == tops.end() ? map.height() : top[1];
                cut(*left, *top, right - *left, bottom - *top);
            }
        }
        portals = std::make_shared<const ZonePortals>(zones);
        for (std::size_t z = 0; z < zones.size(); ++z) {
            costs.emplace_back(portals);
        }
    }

    void cut(int left, int top, int width, int height) {
        const float half_x = 0.5F * kZoneCell_m * static_cast<float>(width);
        const float half_z = 0.5F * kZoneCell_m * static_cast<float>(height);
        const float more = kZoneCell_m * static_cast<float>(margin);
        GridMap cells(width + 2 * margin, height + 2 * margin);
        for (int y = 0; y < height + 2 * margin; ++y) {
            for (int x = 0; x < width + 2 * margin; ++x) {
                const Cell c{static_cast<std::uint16_t>(x), static_cast<std::uint16_t>(y)};
                const int column = left - margin + x;
                const int row = top - margin + y;
                const Cell from{static_cast<std::uint16_t>(column),
                                static_cast<std::uint16_t>(row)};
                cells.set_passable(c, column >= 0 && row >= 0 && whole.passable(from));
            }
        }
        grounds.push_back(
            {GroundGrid({-half_x - more, -half_z - more, half_x + more, half_z + more},
                        kZoneCell_m),
             cells,
             std::vector<float>(cells.places(), 0.0F)});
        corners.push_back({left, top});
        sizes.push_back({width, height});
        zones.push_back(
            {&grounds.back(),
             static_cast<double>(half_x) + static_cast<double>(kZoneCell_m) * left + 1e5,
             static_cast<double>(half_z) + static_cast<double>(kZoneCell_m) * top - 3e4,
             GroundRect{-half_x, -half_z, half_x, half_z}});
        planners.push_back(std::make_unique<GridPlanner>(cells));
    }

    std::uint32_t zone_of(Cell c) const {
        for (std::uint32_t z = 0;; ++z) {
            const int x = c.x - corners[z][0];
            const int y = c.y - corners[z][1];
            if (x >= 0 && y >= 0 && x < sizes[z][0] && y < sizes[z][1]) {
                return z;
            }
        }
    }

    Cell within(std::uint32_t zone, Cell c) const {
        return {static_cast<std::uint16_t>(c.x - corners[zone][0] + margin),
                static_cast<std::uint16_t>(c.y - corners[zone][1] + margin)};
    }

    Spot spot(Cell c) const {
        const std::uint32_t z = zone_of(c);
        return grounds[z].grid.centre(within(z, c));
    }

    GridMap whole;
    int margin;
    std::vector<GroundMap> grounds;
    std::vector<std::array<int, 2>> corners;  // of the zones, without the parts beyond
    std::vector<std::array<int, 2>> sizes;
    std::vector<ZoneGround> zones;
    std::vector<std::unique_ptr<GridPlanner>> planners;
    std::shared_ptr<const ZonePortals> portals;
    std::vector<PortalCosts> costs;  // by zone
};

/// The length from a cell of the whole map to cells of its zone.
ZonePortals::LengthTo length_from(CutMap& m, Cell start) {
    return [&m, start](Cell c) -> std::optional<float> {
        const std::uint32_t zone = m.zone_of(start);
        GridQuery q;
        q.start = m.within(zone, start);
        q.goal = c;
        const GridAnswer a = m.planners[zone]->plan(q);
        return a.outcome == PathOutcome::kFound
                   ? std::optional<float>(static_cast<float>(a.length) * kZoneCell_m)
                   : std::nullopt;
    };
}

std::optional<ZonePortals::PortalExit> exit_by(CutMap& m,
                                               Cell start,
                                               Cell goal,
                                               std::span<const PortalRow> rows,
                                               ZonePortals::Scratch& scratch) {
    return m.portals->straight_exit(m.zone_of(start),
                                    m.spot(start),
                                    m.zone_of(goal),
                                    m.spot(goal),
                                    rows,
                                    length_from(m, start),
                                    scratch);
}

/// An exit as a zone comes to know it: whatever is unknown is found before the next try.
std::optional<ZonePortals::PortalExit> settled_exit(CutMap& m, Cell start, Cell goal) {
    PortalCosts& costs = m.costs[m.zone_of(start)];
    ZonePortals::Scratch scratch;
    auto exit = exit_by(m, start, goal, costs.rows(), scratch);
    while (exit && exit->rough) {
        for (const std::uint32_t portal : scratch.unknown) {
            costs.want(portal);
        }
        while (costs.wanted() > 0) {
            costs.advance(10'000);
        }
        const float least = exit->cost_m;
        exit = exit_by(m, start, goal, costs.rows(), scratch);
        EXPECT_TRUE(exit && exit->cost_m >= least - 1e-3F) << "a rough cost promises too much only";
    }
    return exit;
}

/// The rows of all portals.
std::vector<PortalRow> all_rows(const ZonePortals& portals) {
    std::vector<PortalRow> rows(portals.portals());
    FlowField field;
    for (std::uint32_t p = 0; p < rows.size(); ++p) {
        field.build(portals.map_beyond(p), portals.entry(p));
        portals.read_row(p, field, rows[p]);
    }
    return rows;
}

/// Cells of the path on which each zone plans its own part, as far as its exit, and hands over
/// beyond the border; below 0 where one can't.
double walked(CutMap& m, Cell start, Cell goal) {
    double length = 0.0;
    Cell at = start;
    for (std::size_t zones = 0; zones <= m.portals->portals(); ++zones) {
        const std::uint32_t zone = m.zone_of(at);
        const GroundGrid& grid = m.grounds[zone].grid;
        GridQuery q;
        q.start = m.within(zone, at);
        const Spot here = m.portals->local(m.zone_of(goal), m.spot(goal), zone);
        if (grid.contains(here) && m.planners[zone]->joined(q.start, grid.cell(here))) {
            q.goal = grid.cell(here);
            return length + m.planners[zone]->plan(q).length;
        }
        const auto exit = settled_exit(m, at, goal);
        if (!exit) {
            return -1.0;
        }
        q.goal = grid.cell(exit->at);  // of a place beyond the border the cell before it
        const GridAnswer a = m.planners[zone]->plan(q);
        if (a.outcome != PathOutcome::kFound) {
            return -1.0;
        }
        const Spot inside = grid.centre(q.goal);
        const auto beyond = [&](float to, float from) {
            return static_cast<int>(std::lround((to - from) / kZoneCell_m));
        };
        at = {static_cast<std::uint16_t>(q.goal.x + m.corners[zone][0] - m.margin +
                                         beyond(exit->at.x, inside.x)),
              static_cast<std::uint16_t>(q.goal.y + m.corners[zone][1] - m.margin +
                                         beyond(exit->at.z, inside.z))};
        length += a.length + 1.0;
    }
    return -1.0;
}

Cell any_cell_of(const GridMap& map, core::Rng& rng) {
    return {static_cast<std::uint16_t>(rng.below(static_cast<std::uint32_t>(map.width()))),
            static_cast<std::uint16_t>(rng.below(static_cast<std::uint32_t>(map.height())))};
}

GridMap map_of_seed(std::uint64_t seed) {
    return seed % 2 == 0 ? rooms_map(150, 120, 11, seed) : random_map(150, 120, 0.33F, seed);
}

/// Of zones whose maps go beyond them by so many cells.
class ZonePortalsBeyond : public testing::TestWithParam<int> {};

INSTANTIATE_TEST_SUITE_P(Maps, ZonePortalsBeyond, testing::Values(0, 3));

TEST_P(ZonePortalsBeyond, LeadThroughSeveralZonesToWhateverCanBeReached) {
    core::Rng rng(51);
    double sum = 0.0;
    double sum_best = 0.0;
    for (std::uint64_t seed = 1; seed <= 6; ++seed) {
        const GridMap map = map_of_seed(seed);
        CutMap m(map, {0, 40, 101}, {0, 70}, GetParam());
        EXPECT_GT(m.portals->portals(), 5U);
        for (int i = 0; i < 150; ++i) {
            const Cell start = any_cell_of(map, rng);
            const Cell goal = any_cell_of(map, rng);
            if (!map.passable(start) || !map.passable(goal)) {
                continue;
            }
            const double best = all_lengths(
                map, start)[std::size_t{goal.y} * static_cast<std::size_t>(map.width()) + goal.x];
            const double length = walked(m, start, goal);
            ASSERT_EQ(length >= 0.0, best != kNoPath) << seed;
            if (best != kNoPath) {
                ASSERT_GE(length, best - 0.01);
                sum += length;
                sum_best += best;
            }
        }
    }
    RecordProperty("length_over_best", std::to_string(sum / sum_best));
    // Portals are up to 24 cells apart: a walker that crosses beside one goes up to 12 aside and
    // back, on paths of about a hundred. Most borders are crossed at doors, where there is no
    // choice.
    EXPECT_LT(sum / sum_best, 1.1);
}

TEST_P(ZonePortalsBeyond, CostByWhatIsFoundOnDemandWhatTheyCostByAllRows) {
    core::Rng rng(52);
    std::size_t rough = 0;
    std::size_t queries = 0;
    for (std::uint64_t seed = 1; seed <= 6; ++seed) {
        const GridMap map = map_of_seed(seed);
        CutMap m(map, {0, 40, 101}, {0, 70}, GetParam());
        const std::vector<PortalRow> rows = all_rows(*m.portals);
        for (int i = 0; i < 150; ++i) {
            const Cell start = any_cell_of(map, rng);
            const Cell goal = any_cell_of(map, rng);
            if (!map.passable(start) || !map.passable(goal)) {
                continue;
            }
            ZonePortals::Scratch scratch;
            const auto whole = exit_by(m, start, goal, rows, scratch);
            const auto first = exit_by(m, start, goal, m.costs[m.zone_of(start)].rows(), scratch);
            const auto exit = settled_exit(m, start, goal);
            ASSERT_EQ(exit.has_value(), whole.has_value()) << seed;
            ASSERT_EQ(first.has_value(), whole.has_value()) << "reachable is known at once";
            if (!exit) {
                continue;
            }
            EXPECT_FALSE(whole->rough);
            // Sums of some ten floats of up to some hundred metres, in another order.
            ASSERT_NEAR(exit->cost_m, whole->cost_m, 1e-3F) << seed;
            ++queries;
            rough += first->rough ? 1 : 0;
        }
        std::size_t known = 0;
        for (const PortalCosts& costs : m.costs) {
            known += static_cast<std::size_t>(
                std::count_if(costs.rows().begin(), costs.rows().end(), [](const PortalRow& row) {
                    return !row.empty();
                }));
        }
        EXPECT_LT(known, m.costs.size() * rows.size()) << "none is found that no path needs";
    }
    EXPECT_GT(rough, 20U) << "paths that depend on costs across zones";
    EXPECT_LT(rough, queries / 2) << "what is known serves later paths";
}

TEST(ZonePortals, LeaveAZoneWhereNoPathWithinItLeadsThere) {
    // Two zones; in the left one a wall that only the right one leads around.
    GridMap cells(10, 4);
    for (std::uint16_t y = 0; y < 4; ++y) {
        for (std::uint16_t x = 0; x < 10; ++x) {
            cells.set_passable({x, y}, !(y == 2 && x < 7));
        }
    }
    CutMap m(cells, {0, 6}, {0});
    GridPlanner planner(cells);
    GridQuery q;
    q.goal = {0, 3};
    // Around the wall's end: seven cells there and back, and three down.
    EXPECT_NEAR(walked(m, {0, 0}, {0, 3}), planner.plan(q).length, 1.0);
}

TEST(ZonePortals, LeadPastAZoneWhoseNearestBorderIsADeadEnd) {
    // Four zones; to the right of the first one a pocket that nothing leads out of.
    const GridMap cells = map_of(
        {"....#.....", "....#.....", "....#.....", "..###.....", "..........", ".........."});
    CutMap m(cells, {0, 3}, {0, 3});
    const auto exit = settled_exit(m, {1, 1}, {8, 1});
    ASSERT_TRUE(exit);
    EXPECT_EQ(m.portals->zone_of(0, exit->at), 2U) << "down, not into the pocket";
    EXPECT_GT(walked(m, {1, 1}, {8, 1}), 0.0);
    ZonePortals::Scratch scratch;
    EXPECT_FALSE(m.portals->straight_exit(
        0, m.spot({1, 1}), 1, {100.0F, 0.0F}, m.costs[0].rows(), length_from(m, {1, 1}), scratch));
}

TEST(PortalCosts, AreThereInTheSameTickAfterTheyWereSavedInAny) {
    const GridMap map = map_of_seed(1);
    CutMap m(map, {0, 40, 101}, {0, 70});
    PortalCosts& straight = m.costs[0];
    PortalCosts copied(m.portals);
    core::Rng rng(53);
    std::size_t completed = 0;
    std::size_t midway = 0;
    for (int tick = 0; tick < 400; ++tick) {
        if (tick % 20 == 0) {
            const std::uint32_t portal =
                rng.below(static_cast<std::uint32_t>(m.portals->portals()));
            straight.want(portal);
            copied.want(portal);
        }
        const std::uint64_t units = 1000 + 10 * rng.below(500);
        const bool done = straight.advance(units);
        ASSERT_EQ(copied.advance(units), done) << "tick " << tick;
        completed += done ? 1 : 0;
        const SavedPortalCosts saved = copied.save();
        midway += saved.spread > 0 ? 1 : 0;
        PortalCosts fresh(m.portals);
        ASSERT_EQ(fresh.defect_of(saved), "");
        fresh.load(saved);
        copied = std::move(fresh);
        ASSERT_TRUE(std::equal(straight.rows().begin(),
                               straight.rows().end(),
                               copied.rows().begin(),
                               copied.rows().end()));
    }
    EXPECT_GT(completed, 5U);
    EXPECT_GT(midway, 20U) << "rows are saved half done, too";
    const std::vector<PortalRow> rows = all_rows(*m.portals);
    for (std::uint32_t p = 0; p < rows.size(); ++p) {
        EXPECT_TRUE(straight.rows()[p].empty() || straight.rows()[p] == rows[p]) << p;
    }
}

TEST(PortalCosts, RefuseWhatDoesNotFitTheWorld) {
    CutMap m(random_map(150, 120, 0.0F, 1), {0, 40, 101}, {0, 70});
    m.costs[0].want(3);
    m.costs[0].advance(100'000'000);
    m.costs[0].want(4);
    m.costs[0].want(5);
    m.costs[0].advance(3000);
    const SavedPortalCosts good = m.costs[0].save();
    ASSERT_EQ(good.wanted.size(), 2U);
    ASSERT_GT(good.spread, 0U);
    const auto refused = [&m](const SavedPortalCosts& saved) {
        return !PortalCosts(m.portals).defect_of(saved).empty();
    };
    EXPECT_FALSE(refused(good));
    SavedPortalCosts bad = good;
    bad.rows[0].portal = static_cast<std::uint32_t>(m.portals->portals());
    EXPECT_TRUE(refused(bad)) << "a portal that there is not";
    bad = good;
    bad.rows[0].costs.pop_back();
    EXPECT_TRUE(refused(bad)) << "a row too short";
    bad = good;
    bad.wanted[1] = bad.rows[0].portal;
    EXPECT_TRUE(refused(bad)) << "wanted, and known";
    bad = good;
    bad.wanted[1] = bad.wanted[0];
    EXPECT_TRUE(refused(bad)) << "wanted twice";
    bad = good;
    bad.spread = std::uint64_t{1} << 40U;
    EXPECT_TRUE(refused(bad)) << "more cells than there are";
    bad = good;
    bad.wanted.clear();
    EXPECT_TRUE(refused(bad)) << "cells of no row";
}

}  // namespace

}  // namespace zoned::ai::pathfinding
