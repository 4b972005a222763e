#include "server/ai/pathfinding/grid/ground_map.h"

#include "server/ai/pathfinding/grid/line_of_sight.h"
#include "server/ai/pathfinding/grid_search/grid_planner.h"
#include "tests/unit/pathfinding/walkers.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <utility>

namespace zoned::ai::pathfinding {

namespace {

constexpr GroundRect kTenMetres{-10.0F, -10.0F, 10.0F, 10.0F};
constexpr float kCell_m = 0.5F;
const motion::CharacterLimits kWalker;

GroundMap baked(const std::vector<motion::StaticBox>& boxes,
                const motion::CharacterLimits& limits = kWalker) {
    return bake_ground(motion::StaticGeometry(boxes, 0.0F), limits, kTenMetres, kCell_m);
}

/// Whether a path leads from the place to the other on the map.
bool leads(const GroundMap& map, Spot from, Spot to) {
    GridPlanner planner(map.cells);
    GridQuery q;
    q.start = map.grid.cell(from);
    q.goal = map.grid.cell(to);
    return planner.plan(q).outcome == PathOutcome::kFound;
}

TEST(GroundGrid, TellsCellsFromPlacesAndBack) {
    const GroundGrid grid(kTenMetres, kCell_m);
    ASSERT_EQ(grid.width(), 40);
    ASSERT_EQ(grid.height(), 40);
    for (std::uint16_t y = 0; y < 40; ++y) {
        for (std::uint16_t x = 0; x < 40; ++x) {
            ASSERT_EQ(grid.cell(grid.centre({x, y})), (Cell{x, y}));
        }
    }
    EXPECT_TRUE(grid.contains({-10.0F, 9.99F}));
    EXPECT_FALSE(grid.contains({-10.01F, 0.0F}));
    EXPECT_FALSE(grid.contains({10.0F, 0.0F}));
    EXPECT_FALSE(grid.contains({std::nanf(""), 0.0F}));
    EXPECT_EQ(grid.cell({1e30F, -1e30F}), (Cell{39, 0}));
    EXPECT_EQ(grid.cell({std::nanf(""), std::nanf("")}), (Cell{0, 0}));
}

TEST(GroundGrid, SaysWhyItCantBeLaid) {
    EXPECT_THAT(GroundGrid::defect_of(kTenMetres, 0.0F), testing::HasSubstr("size above 0"));
    EXPECT_THAT(GroundGrid::defect_of(kTenMetres, std::nanf("")), testing::HasSubstr("size"));
    EXPECT_THAT(GroundGrid::defect_of(kTenMetres, 21.0F), testing::HasSubstr("no room"));
    EXPECT_THAT(GroundGrid::defect_of(kTenMetres, 0.001F), testing::HasSubstr("20000 x 20000"));
    EXPECT_THAT(GroundGrid::defect_of({-1e30F, 0.0F, 1e30F, 1.0F}, 1.0F),
                testing::HasSubstr("at most 8192"));
    EXPECT_EQ(GroundGrid::defect_of(kTenMetres, kCell_m), "");
}

TEST(NearestPassable, IsTheNearestOfAll) {
    core::Rng rng(3);
    const GroundGrid grid(kTenMetres, kCell_m);
    GridMap map(40, 40);
    for (int i = 0; i < 60; ++i) {
        map.set_passable(
            {static_cast<std::uint16_t>(rng.below(40)), static_cast<std::uint16_t>(rng.below(40))},
            true);
    }
    for (int i = 0; i < 500; ++i) {
        const Spot s{rng.unit() * 24.0F - 12.0F, rng.unit() * 24.0F - 12.0F};
        const auto off = [&](Cell c) {
            const Spot at = grid.centre(c);
            return (at.x - s.x) * (at.x - s.x) + (at.z - s.z) * (at.z - s.z);
        };
        float least = 1e9F;
        for (std::uint16_t y = 0; y < 40; ++y) {
            for (std::uint16_t x = 0; x < 40; ++x) {
                least = map.passable(Cell{x, y}) ? std::min(least, off({x, y})) : least;
            }
        }
        Cell found;
        ASSERT_TRUE(nearest_passable(map, grid, s, 60, found));
        EXPECT_TRUE(map.passable(found));
        EXPECT_EQ(off(found), least);
    }
    Cell found;
    EXPECT_FALSE(nearest_passable(GridMap(40, 40), grid, {0.0F, 0.0F}, 60, found));
}

/// Set at once, a map equals one that is set cell by cell, however it lies in words of bits.
TEST(GridMap, IsTheSameSetAtOnceAndCellByCell) {
    core::Rng rng(4);
    for (const auto& [width, height] :
         {std::pair(1, 1), {62, 63}, {63, 62}, {64, 130}, {200, 65}}) {
        GridMap one_by_one(width, height);
        for (std::uint16_t y = 0; y < height; ++y) {
            for (std::uint16_t x = 0; x < width; ++x) {
                one_by_one.set_passable({x, y}, rng.below(4) != 0);
            }
        }
        GridMap at_once(width, height);
        at_once.set_all(one_by_one.row_bits());
        EXPECT_EQ(at_once.passable_cells(), one_by_one.passable_cells());
        EXPECT_TRUE(std::ranges::equal(at_once.row_bits(), one_by_one.row_bits()));
        EXPECT_TRUE(std::ranges::equal(at_once.column_bits(), one_by_one.column_bits()))
            << width << " x " << height;
        for (int i = 0; i < 200; ++i) {
            const Cell first{static_cast<std::uint16_t>(rng.below(width)),
                             static_cast<std::uint16_t>(rng.below(height))};
            const int cells = 1 + static_cast<int>(rng.below(std::min(width - first.x, 70)));
            bool all = true;
            for (int x = first.x; x < first.x + cells; ++x) {
                all = all && at_once.passable(Cell{static_cast<std::uint16_t>(x), first.y});
            }
            ASSERT_EQ(at_once.all_passable(first, cells), all);
        }
    }
}

TEST(BakeGround, IsOpenWhereNothingStands) {
    const GroundMap map = baked({});
    EXPECT_EQ(map.cells.passable_cells(), 1600U);
}

TEST(BakeGround, GrowsWallsByTheRadiusOfEachSize) {
    for (const float radius : {0.2F, 0.4F, 0.9F}) {
        motion::CharacterLimits limits;
        limits.radius = radius;
        const GroundMap map =
            baked({static_box(Vec3(0.1F, 1.5F, 0.0F), Vec3(0.3F, 1.5F, 4.0F))}, limits);
        for (std::uint16_t y = 0; y < 40; ++y) {
            for (std::uint16_t x = 0; x < 40; ++x) {
                const Spot at = map.grid.centre({x, y});
                const float dx = std::max(std::abs(at.x - 0.1F) - 0.3F, 0.0F);
                const float dz = std::max(std::abs(at.z) - 4.0F, 0.0F);
                if (dx + dz == 0.0F) {
                    EXPECT_FALSE(map.cells.passable(Cell{x, y}) &&
                                 map.floor_m[map.cells.place({x, y})] < 3.0F);
                    continue;
                }
                const float off = std::sqrt(dx * dx + dz * dz) - radius;
                // Movement keeps a millimetre of air (motion::kSkin).
                if (std::abs(off) > 0.002F) {
                    EXPECT_EQ(map.cells.passable(Cell{x, y}), off > 0.0F)
                        << radius << " at " << at.x << ", " << at.z;
                }
            }
        }
    }
}

/// With cells of two metres a step passes what stands between the middles of two cells: a gap in a
/// wall, on the ground and on a deck, that the body fits through or not, and a cleft in the deck.
TEST(BakeGround, LeadsThroughGapsThatTheBodyFitsThroughAndOverNoCleft) {
    constexpr float kBroad_m = 2.0F;
    const auto map_of = [](float deck_m, float gap_m, float cleft_m) {
        std::vector<motion::StaticBox> boxes;
        if (deck_m > 0.0F) {
            const float half = 0.25F * (21.0F - cleft_m);
            for (const float side : {-1.0F, 1.0F}) {
                boxes.push_back(
                    static_box(Vec3(side * (half + 0.5F * cleft_m), 0.5F * deck_m, 0.0F),
                               Vec3(half, 0.5F * deck_m, 10.5F)));
            }
        }
        const float wall = 0.25F * (21.0F - gap_m);
        for (const float side : {-1.0F, 1.0F}) {
            boxes.push_back(
                static_box(Vec3(0.0F, deck_m + 1.5F, 1.0F + side * (wall + 0.5F * gap_m)),
                           Vec3(0.1F, 1.5F, wall)));
        }
        return bake_ground(motion::StaticGeometry(boxes, 0.0F), kWalker, kTenMetres, kBroad_m);
    };
    const Spot left{-1.0F, 1.0F};
    const Spot right{1.0F, 1.0F};
    for (const float deck : {0.0F, 2.0F}) {
        const float body = 2.0F * kWalker.radius;
        EXPECT_TRUE(leads(map_of(deck, body + 0.1F, 0.0F), left, right)) << deck;
        EXPECT_FALSE(leads(map_of(deck, body - 0.1F, 0.0F), left, right)) << deck;
    }
    EXPECT_FALSE(leads(map_of(2.0F, 20.0F, 1.0F), left, right));
}

TEST(BakeGround, StepsOntoLedgesThatMovementClimbsAndNoHigher) {
    for (const float height : {0.1F, 0.28F, 0.5F, 1.0F}) {
        const float half = 0.5F * height;
        const GroundMap map = baked({static_box(Vec3(0.0F, half, 0.0F), Vec3(3.0F, half, 3.0F))});
        EXPECT_EQ(leads(map, {-8.0F, 0.0F}, {0.0F, 0.0F}), height <= kWalker.step_up) << height;
        EXPECT_NEAR(map.floor_m[map.cells.place(map.grid.cell({0.0F, 0.0F}))], height, 0.005F);
    }
}

TEST(BakeGround, ClimbsSlopesThatCarryAndNoSteeper) {
    // A slab whose top runs from below the ground to a platform at its upper end.
    const float limit = std::acos(kWalker.max_slope_cos) * 180.0F / 3.14159265F;
    for (const float degrees : {20.0F, 45.0F, limit + 5.0F, 65.0F}) {
        const float rad = degrees * 3.14159265F / 180.0F;
        const float rise = 3.0F * std::sin(rad);
        const float top = 2.0F * rise;
        const GroundMap map =
            baked({static_box(Vec3(-3.0F * std::cos(rad) + 0.2F * std::sin(rad),
                                   rise - 0.2F * std::cos(rad),
                                   0.0F),
                              Vec3(3.0F, 0.2F, 9.9F),
                              degrees,
                              Vec3::UnitZ()),
                   static_box(Vec3(3.0F, 0.5F * top, 0.0F), Vec3(3.0F, 0.5F * top, 9.9F))});
        EXPECT_EQ(leads(map, {-9.0F, 0.0F}, {3.0F, 0.0F}), degrees < limit) << degrees;
    }
}

TEST(BakeGround, ClimbsStairs) {
    std::vector<motion::StaticBox> boxes;
    for (int k = 0; k < 8; ++k) {
        const float half = 0.1F * static_cast<float>(k + 1);
        boxes.push_back(static_box(Vec3(0.4F * static_cast<float>(k) - 3.0F, half, 0.0F),
                                   Vec3(0.2F, half, 9.9F)));
    }
    boxes.push_back(static_box(Vec3(2.5F, 0.8F, 0.0F), Vec3(2.5F, 0.8F, 9.9F)));
    EXPECT_TRUE(leads(baked(boxes), {-8.0F, 0.0F}, {3.0F, 0.0F}));
    motion::CharacterLimits stiff;
    stiff.step_up = 0.05F;
    EXPECT_FALSE(leads(baked(boxes, stiff), {-8.0F, 0.0F}, {3.0F, 0.0F}));
}

TEST(BakeGround, LeadsUnderARoofAndStopsAtALowOne) {
    for (const float height : {2.2F, 1.5F}) {
        const GroundMap map =
            baked({static_box(Vec3(0.0F, height + 0.1F, 0.0F), Vec3(3.0F, 0.1F, 9.95F))});
        EXPECT_EQ(leads(map, {-8.0F, 0.0F}, {8.0F, 0.0F}), height > 1.8F) << height;
    }
}

TEST(BakeGround, LeadsOverABridgeAndUpToARoofOnlyWhereStairsLead) {
    // A platform at 3 m, open below. With a ramp to it, its top is the ground, else the floor below
    // is.
    const motion::StaticBox roof = static_box(Vec3(4.0F, 2.9F, 0.0F), Vec3(4.0F, 0.1F, 3.0F));
    const float slope = std::asin(0.5F);
    const motion::StaticBox ramp = static_box(
        Vec3(-3.0F * std::cos(slope) + 0.1F * std::sin(slope), 1.5F - 0.1F * std::cos(slope), 0.0F),
        Vec3(3.0F, 0.1F, 2.0F),
        30.0F,
        Vec3::UnitZ());
    const auto floor_at = [](const GroundMap& map, Spot s) {
        return map.floor_m[map.cells.place(map.grid.cell(s))];
    };
    EXPECT_NEAR(floor_at(baked({roof}), {4.0F, 0.0F}), 0.0F, 0.005F);
    const GroundMap both = baked({roof, ramp});
    EXPECT_NEAR(floor_at(both, {4.0F, 0.0F}), 3.0F, 0.005F);
    EXPECT_TRUE(leads(both, {-9.0F, 0.0F}, {4.0F, 0.0F}));
    // No path leads over its edge.
    EXPECT_FALSE(both.cells.passable(both.grid.cell({4.0F, 2.9F})));
    EXPECT_TRUE(both.cells.passable(both.grid.cell({4.0F, 4.0F})));
}

TEST(BakeGround, FollowsHeightsAndStopsWhereTheyAreTooSteep) {
    // A ridge across: 45 degrees where |z| > 4, a cliff of 70 elsewhere.
    const auto heights = std::make_shared<std::vector<float>>();
    for (int k = 0; k <= 40; ++k) {
        for (int i = 0; i <= 40; ++i) {
            const float x = std::abs(static_cast<float>(i - 20) * 0.5F);
            const bool gentle = std::abs(k - 20) > 8;
            const float slope = gentle ? 0.7F : 2.7F;
            heights->push_back(std::max(0.0F, 2.8F - slope * x) + 1.0F);
        }
    }
    motion::HeightGrid grid{41, 41, 0.5F, 0.5F, 1.0F, *heights};
    motion::StaticSurface surface;
    surface.surface = std::make_shared<motion::Surface>(grid, heights);
    const motion::StaticGeometry world({}, -50.0F, 16.0F, {surface});
    const GroundMap whole = bake_ground(world, kWalker, kTenMetres, kCell_m);
    EXPECT_TRUE(leads(whole, {-8.0F, 0.0F}, {8.0F, 0.0F}));
    const GroundMap cliff = bake_ground(world, kWalker, {-10.0F, -3.0F, 10.0F, 3.0F}, kCell_m);
    EXPECT_FALSE(leads(cliff, {-8.0F, 0.0F}, {8.0F, 0.0F}));
    const Place flat = whole.cells.place(whole.grid.cell({-8.0F, 0.0F}));
    EXPECT_NEAR(whole.floor_m[flat], 1.0F, 0.005F);
}

/// Paths requested and walked in random worlds, planned for one size, walked by another.
struct Walked {
    int paths = 0;
    int stuck = 0;
    double ticks_over_best = 0.0;
};

template <class MakeWorld>
Walked walk_random_worlds(const motion::CharacterLimits& planned,
                          const MakeWorld& make_world,
                          int worlds) {
    Walked w;
    core::Rng rng(11);
    for (int i = 0; i < worlds; ++i) {
        const motion::StaticGeometry world = make_world(rng);
        const GroundMap map = bake_ground(world, planned, {-20.0F, -20.0F, 20.0F, 20.0F}, kCell_m);
        GridPlanner planner(map.cells);
        for (int k = 0; k < 40; ++k) {
            GridQuery q;
            Cell goal;
            const auto any = [&] {
                return Spot{rng.unit() * 40.0F - 20.0F, rng.unit() * 40.0F - 20.0F};
            };
            if (!nearest_passable(map.cells, map.grid, any(), 9, q.start) ||
                !nearest_passable(map.cells, map.grid, any(), 9, goal)) {
                continue;
            }
            q.goal = goal;
            if (planner.plan(q).outcome != PathOutcome::kFound || q.start == q.goal) {
                continue;
            }
            std::vector<Cell> cells(planner.path().corners().begin(),
                                    planner.path().corners().end());
            std::uint32_t looked = 0;
            pull(map.cells, cells, looked);
            std::vector<Spot> corners;
            double length = 0.0;
            for (std::size_t c = 1; c < cells.size(); ++c) {
                corners.push_back(map.grid.centre(cells[c]));
                length +=
                    kCell_m * std::hypot(cells[c].x - cells[c - 1].x, cells[c].y - cells[c - 1].y);
            }
            const double best = length / kWalker.speed * 30.0;
            const int most = static_cast<int>(3.0 * best) + 60;
            const int ticks =
                ticks_to_walk(world, kWalker, map, q.start, corners, 0.6F * kCell_m, most);
            ++w.paths;
            w.stuck += ticks >= most ? 1 : 0;
            w.ticks_over_best = std::max(w.ticks_over_best, ticks - best);
        }
    }
    return w;
}

TEST(BakeGround, AgreesWithMovementSoThatEveryPulledWayCanBeWalked) {
    const auto make = [](core::Rng& rng) {
        return random_world(rng, 36.0F, 40);
    };
    const Walked w = walk_random_worlds(kWalker, make, 12);
    EXPECT_GT(w.paths, 300);
    EXPECT_EQ(w.stuck, 0);
    // The check itself: paths for a thinner agent that climbs higher lead where this one can't go.
    motion::CharacterLimits other;
    other.radius = 0.1F;
    other.half_segment = 0.8F;
    other.step_up = 0.09F;
    const Walked wrong = walk_random_worlds(other, make, 12);
    EXPECT_GT(wrong.stuck, 5);
}

TEST(BakeGround, AgreesWithMovementOnHills) {
    // Hills of 2 m with cliffs between them; some can be walked on and some cannot.
    const auto make = [](core::Rng& rng) {
        const auto heights = std::make_shared<std::vector<float>>();
        const float along = rng.range(0.2F, 0.6F);
        const float across = rng.range(0.2F, 0.6F);
        for (int k = 0; k <= 50; ++k) {
            for (int i = 0; i <= 50; ++i) {
                const float wave = 2.0F * std::sin(along * static_cast<float>(i)) *
                                   std::cos(across * static_cast<float>(k));
                heights->push_back(wave + (wave > 1.0F ? rng.range(0.0F, 1.5F) : 0.0F));
            }
        }
        motion::StaticSurface surface;
        surface.surface = std::make_shared<motion::Surface>(
            motion::HeightGrid{51, 51, 1.0F, 1.0F, 1.0F, *heights}, heights);
        return motion::StaticGeometry({}, -20.0F, 16.0F, {surface});
    };
    const Walked w = walk_random_worlds(kWalker, make, 5);
    EXPECT_GT(w.paths, 150);
    // A character that passes beside a steep face may slide off its line, down to where no cell is.
    EXPECT_LE(w.stuck, w.paths / 100);
    motion::CharacterLimits climber;
    climber.max_slope_cos = 0.3F;
    EXPECT_GT(walk_random_worlds(climber, make, 5).stuck, w.paths / 10);
}

}  // namespace

}  // namespace zoned::ai::pathfinding
