#include "server/ai/pathfinding/requests/zone_portals.h"

#include "tests/unit/pathfinding/grid_reference.h"
#include "shared/core/rng.h"

#include <gmock/gmock.h>

#include <array>
#include <memory>

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
        portals = std::make_unique<ZonePortals>(zones);
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
    std::unique_ptr<ZonePortals> portals;
};

/// Cells of the path when each zone plans its own part and hands over beyond the border; below 0
/// where one can't.
double walked(CutMap& m, Cell start, std::span<const ZonePathSegment> segments) {
    double length = 0.0;
    Cell at = start;
    for (std::size_t i = 0; i < segments.size(); ++i) {
        const std::uint32_t zone = segments[i].zone;
        if (m.zone_of(at) != zone) {
            return -1.0;
        }
        GridQuery q;
        q.start = m.within(zone, at);
        const GroundGrid& grid = m.grounds[zone].grid;
        q.goal = grid.cell(segments[i].to);  // of a place beyond the border the cell before it
        const GridAnswer a = m.planners[zone]->plan(q);
        if (a.outcome != PathOutcome::kFound) {
            return -1.0;
        }
        length += a.length;
        at = {static_cast<std::uint16_t>(q.goal.x + m.corners[zone][0] - m.margin),
              static_cast<std::uint16_t>(q.goal.y + m.corners[zone][1] - m.margin)};
        if (i + 1 < segments.size()) {
            const Spot inside = grid.centre(q.goal);
            at.x = static_cast<std::uint16_t>(
                at.x + std::lround((segments[i].to.x - inside.x) / kZoneCell_m));
            at.y = static_cast<std::uint16_t>(
                at.y + std::lround((segments[i].to.z - inside.z) / kZoneCell_m));
            length += 1.0;
        }
    }
    return length;
}

/// Of zones whose maps go beyond them by so many cells.
class ZonePortalsBeyond : public testing::TestWithParam<int> {};

INSTANTIATE_TEST_SUITE_P(Maps, ZonePortalsBeyond, testing::Values(0, 3));

TEST_P(ZonePortalsBeyond, LeadThroughSeveralZonesToWhateverCanBeReached) {
    core::Rng rng(51);
    double sum = 0.0;
    double sum_best = 0.0;
    for (std::uint64_t seed = 1; seed <= 6; ++seed) {
        const GridMap map =
            seed % 2 == 0 ? rooms_map(150, 120, 11, seed) : random_map(150, 120, 0.33F, seed);
        CutMap m(map, {0, 40, 101}, {0, 70}, GetParam());
        EXPECT_GT(m.portals->portals(), 5U);
        GridPlanner planner(map);
        for (int i = 0; i < 150; ++i) {
            const auto any = [&] {
                return Cell{static_cast<std::uint16_t>(rng.below(150)),
                            static_cast<std::uint16_t>(rng.below(120))};
            };
            GridQuery q;
            q.start = any();
            q.goal = any();
            const GridAnswer best = planner.plan(q);
            std::vector<ZonePathSegment> segments;
            const std::uint32_t from = m.zone_of(q.start);
            const std::uint32_t to = m.zone_of(q.goal);
            const PathOutcome outcome = m.portals->route(
                *m.planners[from], from, m.spot(q.start), to, m.spot(q.goal), segments);
            ASSERT_EQ(outcome, best.outcome) << seed;
            if (outcome != PathOutcome::kFound) {
                continue;
            }
            const double length = walked(m, q.start, segments);
            ASSERT_GE(length, best.length - 0.01);
            sum += length;
            sum_best += best.length;
        }
    }
    // Portals are up to 24 cells apart: a walker that crosses beside one goes up to 12 aside and
    // back, on paths of about a hundred. Most borders are crossed at doors, where there is no
    // choice.
    EXPECT_LT(sum / sum_best, 1.1);
}

TEST(ZonePortals, LeaveAZoneWhereTheWayWithinItIsLongerOrMissing) {
    // Two zones; in the left one a wall that only the right one leads around.
    GridMap cells(10, 4);
    for (std::uint16_t y = 0; y < 4; ++y) {
        for (std::uint16_t x = 0; x < 10; ++x) {
            cells.set_passable({x, y}, !(y == 2 && x < 7));
        }
    }
    CutMap m(cells, {0, 6}, {0});
    std::vector<ZonePathSegment> segments;
    ASSERT_EQ(m.portals->route(*m.planners[0], 0, m.spot({0, 0}), 0, m.spot({0, 3}), segments),
              PathOutcome::kFound);
    ASSERT_EQ(segments.size(), 3U);
    EXPECT_EQ(segments[0].zone, 0U);
    EXPECT_EQ(segments[1].zone, 1U);
    EXPECT_EQ(segments[2].zone, 0U);
    // Around the wall's end: seven cells there and back, and three down.
    GridPlanner planner(cells);
    GridQuery q;
    q.goal = {0, 3};
    EXPECT_NEAR(walked(m, {0, 0}, segments), planner.plan(q).length, 1.0);
}

TEST(ZonePortals, LeadPastAZoneWhoseNearestBorderIsADeadEnd) {
    // Four zones; to the right of the first one a pocket that nothing leads out of.
    const GridMap cells = map_of(
        {"....#.....", "....#.....", "....#.....", "..###.....", "..........", ".........."});
    CutMap m(cells, {0, 3}, {0, 3});
    std::vector<ZonePathSegment> segments;
    ASSERT_EQ(m.portals->route(*m.planners[0], 0, m.spot({1, 1}), 1, m.spot({8, 1}), segments),
              PathOutcome::kFound);
    std::vector<std::uint32_t> through;
    for (const ZonePathSegment& segment : segments) {
        through.push_back(segment.zone);
    }
    EXPECT_EQ(through, (std::vector<std::uint32_t>{0, 2, 3, 1}));
    ZonePortals::Scratch scratch;
    const auto length = [&](Cell c) -> std::optional<float> {
        GridQuery q;
        q.start = m.within(0, {1, 1});
        q.goal = c;
        const GridAnswer a = m.planners[0]->plan(q);
        return a.outcome == PathOutcome::kFound ? std::optional<float>(a.length) : std::nullopt;
    };
    EXPECT_EQ(m.portals->straight_exit(0, m.spot({1, 1}), 1, m.spot({8, 1}), length, scratch),
              segments[0].to);
    EXPECT_FALSE(m.portals->straight_exit(0, m.spot({1, 1}), 1, {100.0F, 0.0F}, length, scratch));
}

}  // namespace

}  // namespace zoned::ai::pathfinding
