#include "server/ai/pathfinding/grid/line_of_sight.h"

#include "server/ai/pathfinding/grid_search/grid_planner.h"
#include "tests/unit/pathfinding/grid_reference.h"
#include "shared/core/rng.h"

#include <gmock/gmock.h>

#include <cmath>

namespace zoned::ai::pathfinding {

namespace {

/// Every cell that the closed line touches, tested one by one with whole numbers. The line joins
/// the middles (in half cells). It touches a closed square where two conditions hold (separating
/// axes): the square's corners do not all lie strictly on one side of it, and the boxes overlap.
bool sees_by_all_cells(const GridMap& map, Cell a, Cell b) {
    const int ax = 2 * a.x + 1;
    const int ay = 2 * a.y + 1;
    const int bx = 2 * b.x + 1;
    const int by = 2 * b.y + 1;
    for (int y = 0; y < map.height(); ++y) {
        for (int x = 0; x < map.width(); ++x) {
            const Cell c{static_cast<std::uint16_t>(x), static_cast<std::uint16_t>(y)};
            if (map.passable(c)) {
                continue;
            }
            if (2 * x > std::max(ax, bx) || 2 * x + 2 < std::min(ax, bx) ||
                2 * y > std::max(ay, by) || 2 * y + 2 < std::min(ay, by)) {
                continue;
            }
            int above = 0;
            int below = 0;
            for (const int cx : {2 * x, 2 * x + 2}) {
                for (const int cy : {2 * y, 2 * y + 2}) {
                    const int side = (bx - ax) * (cy - ay) - (by - ay) * (cx - ax);
                    above += side > 0 ? 1 : 0;
                    below += side < 0 ? 1 : 0;
                }
            }
            if (above < 4 && below < 4) {
                return false;
            }
        }
    }
    return true;
}

TEST(Sees, IsWhatALookAtEveryCellSaysFromEitherEnd) {
    core::Rng rng(5);
    int seen = 0;
    for (std::uint64_t seed = 1; seed <= 200; ++seed) {
        const GridMap map = random_map(17, 13, seed % 2 == 0 ? 0.05F : 0.2F, seed);
        for (int i = 0; i < 100; ++i) {
            const Cell a{static_cast<std::uint16_t>(rng.below(17)),
                         static_cast<std::uint16_t>(rng.below(13))};
            const Cell b{static_cast<std::uint16_t>(rng.below(17)),
                         static_cast<std::uint16_t>(rng.below(13))};
            std::uint32_t looked = 0;
            const bool expected = sees_by_all_cells(map, a, b);
            seen += expected ? 1 : 0;
            ASSERT_EQ(sees(map, a, b, looked), expected)
                << seed << ": " << a.x << ", " << a.y << " to " << b.x << ", " << b.y;
            ASSERT_EQ(sees(map, b, a, looked), expected);
        }
    }
    EXPECT_GT(seen, 1000);
}

TEST(Pull, KeepsEndsStaysFreeAndIsNeverLonger) {
    core::Rng rng(6);
    int shorter = 0;
    for (std::uint64_t seed = 1; seed <= 40; ++seed) {
        GridPlanner planner(rooms_map(60, 50, 9, seed));
        for (int i = 0; i < 20; ++i) {
            GridQuery q;
            q.start = {static_cast<std::uint16_t>(rng.below(60)),
                       static_cast<std::uint16_t>(rng.below(50))};
            q.goal = {static_cast<std::uint16_t>(rng.below(60)),
                      static_cast<std::uint16_t>(rng.below(50))};
            const GridAnswer a = planner.plan(q);
            if (a.outcome != PathOutcome::kFound || q.start == q.goal) {
                continue;
            }
            std::vector<Cell> corners(planner.path().corners().begin(),
                                      planner.path().corners().end());
            std::uint32_t looked = 0;
            pull(planner.map(), corners, looked);
            ASSERT_EQ(corners.front(), q.start);
            ASSERT_EQ(corners.back(), q.goal);
            double length = 0.0;
            for (std::size_t k = 1; k < corners.size(); ++k) {
                ASSERT_TRUE(sees(planner.map(), corners[k - 1], corners[k], looked));
                length +=
                    std::hypot(corners[k].x - corners[k - 1].x, corners[k].y - corners[k - 1].y);
            }
            ASSERT_LE(length, a.length + kRounding);
            shorter += length < a.length - 0.01 ? 1 : 0;
        }
    }
    EXPECT_GT(shorter, 100);
}

}  // namespace

}  // namespace zoned::ai::pathfinding
