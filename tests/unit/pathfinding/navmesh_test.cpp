#include "server/ai/pathfinding/navmesh/navmesh.h"

#include "server/ai/pathfinding/grid_search/grid_planner.h"
#include "tests/unit/allocation_count.h"
#include "tests/unit/pathfinding/walkers.h"

#include <gmock/gmock.h>

#include <cmath>
#include <memory>

namespace zoned::ai::pathfinding {

namespace {

constexpr GroundRect kTwentyMetres{-10.0F, -10.0F, 10.0F, 10.0F};
const motion::CharacterLimits kPerson;

Navmesh mesh_of(const std::vector<motion::StaticBox>& boxes,
                const motion::CharacterLimits& limits = kPerson) {
    auto mesh = Navmesh::bake(motion::StaticGeometry(boxes, 0.0F), limits, kTwentyMetres);
    EXPECT_TRUE(mesh.ok());
    return std::move(mesh).value();
}

PathOutcome outcome_of(const Navmesh& mesh, const Vec3& from, const Vec3& to) {
    NavmeshSearch search;
    return search.plan(mesh, from, to, 1.0F).outcome;
}

/// Largest distance over the ground from a point of the path to the mesh.
float off_mesh(const Navmesh& mesh, std::span<const Vec3> corners) {
    float most = 0.0F;
    for (std::size_t i = 1; i < corners.size(); ++i) {
        const Vec3 segment = corners[i] - corners[i - 1];
        const int steps = 1 + static_cast<int>(segment.norm() / 0.1F);
        for (int k = 0; k <= steps; ++k) {
            const Vec3 at =
                corners[i - 1] + segment * (static_cast<float>(k) / static_cast<float>(steps));
            Vec3 on;
            if (mesh.nearest(at, 2.0F, on) == Navmesh::kNone) {
                return 2.0F;
            }
            most = std::max(most, Vec2(at.x() - on.x(), at.z() - on.z()).norm());
        }
    }
    return most;
}

TEST(Navmesh, KeepsAwayFromWallsByTheRadiusOfEachSize) {
    // Two walls with a gap of 1.6 m.
    const std::vector<motion::StaticBox> boxes{
        static_box(Vec3(0.0F, 1.5F, -5.4F), Vec3(0.2F, 1.5F, 4.6F)),
        static_box(Vec3(0.0F, 1.5F, 5.4F), Vec3(0.2F, 1.5F, 4.6F))};
    EXPECT_EQ(outcome_of(mesh_of(boxes), Vec3(-8, 0, 0), Vec3(8, 0, 0)), PathOutcome::kFound);
    motion::CharacterLimits wide;
    wide.radius = 1.0F;
    EXPECT_EQ(outcome_of(mesh_of(boxes, wide), Vec3(-8, 0, 0), Vec3(8, 0, 0)),
              PathOutcome::kUnreachable);
    const Navmesh mesh = mesh_of(boxes);
    for (const Vec3& v : mesh.vertices()) {
        const float dx = std::max(std::abs(v.x()) - 0.2F, 0.0F);
        if (std::abs(v.z()) > 0.8F && std::abs(v.z()) < 9.5F) {
            EXPECT_GE(dx, kPerson.radius - 1.8F * 0.25F);
        }
    }
}

TEST(Navmesh, HasFloorsOneOverTheOther) {
    // A platform at 3 m on the right, and a ramp of 27 degrees to it from the left.
    const float slope = std::asin(0.45F);
    const float length = 3.0F / 0.45F;
    const std::vector<motion::StaticBox> boxes{
        static_box(Vec3(5.0F, 2.9F, 0.0F), Vec3(4.9F, 0.1F, 4.0F)),
        static_box(Vec3(-0.5F * length * std::cos(slope) + 0.1F * std::sin(slope) + 0.1F,
                        1.5F - 0.1F * std::cos(slope),
                        0.0F),
                   Vec3(0.5F * length, 0.1F, 2.0F),
                   slope * 180.0F / 3.14159265F,
                   Vec3::UnitZ())};
    const Navmesh mesh = mesh_of(boxes);
    NavmeshSearch search;
    const Vec3 below(6.0F, 0.0F, 0.0F);
    const Vec3 above(6.0F, 3.0F, 0.0F);
    const Vec3 outside(-9.0F, 0.0F, 0.0F);
    EXPECT_EQ(search.plan(mesh, outside, below, 1.0F).outcome, PathOutcome::kFound);
    EXPECT_LT(search.corners().back().y(), 0.3F);
    EXPECT_EQ(search.plan(mesh, outside, above, 1.0F).outcome, PathOutcome::kFound);
    EXPECT_NEAR(search.corners().back().y(), 3.0F, 0.15F);
    EXPECT_LT(off_mesh(mesh, search.corners()), 0.05F);
    // From under the platform onto it: out, up the ramp, and back.
    const NavmeshSearch::NavmeshAnswer up = search.plan(mesh, below, above, 1.0F);
    EXPECT_EQ(up.outcome, PathOutcome::kFound);
    EXPECT_GT(up.length_m, 2.0F * length);
}

TEST(Navmesh, PutsWhoStandsAtTheRimOfADeckOntoTheDeck) {
    // 4 m wide. An agent uses the middle: its polygon ends 0.4 to 0.65 m from the edge.
    const Navmesh mesh = mesh_of({static_box(Vec3(0.0F, 2.9F, 0.0F), Vec3(4.0F, 0.1F, 2.0F))});
    for (const float z : {0.0F, 1.2F, 1.7F, 1.95F, -1.95F}) {
        Vec3 on;
        ASSERT_NE(mesh.nearest(Vec3(0.5F, 3.0F, z), 4.0F, 100.0F, on), Navmesh::kNone);
        EXPECT_NEAR(on.y(), 3.0F, 0.15F) << z;
        EXPECT_LE(std::abs(on.z() - z), kPerson.radius + 1.8F * 0.25F);
        ASSERT_NE(mesh.nearest(Vec3(0.5F, 0.0F, z), 4.0F, 100.0F, on), Navmesh::kNone);
        EXPECT_EQ(Vec2(on.x(), on.z()), Vec2(0.5F, z)) << "below it";
        EXPECT_NEAR(on.y(), 0.0F, 0.1F);
    }
    // In the air beside it, nearer to the ground.
    Vec3 on;
    ASSERT_NE(mesh.nearest(Vec3(0.5F, 1.2F, 2.5F), 4.0F, 100.0F, on), Navmesh::kNone);
    EXPECT_NEAR(on.y(), 0.0F, 0.1F);
}

TEST(Navmesh, KnowsTheHeightsOfHillsWithinItsPolygons) {
    // 2.8 m high, as wide as the area: most of it is one region without a corner on it.
    const auto heights = std::make_shared<std::vector<float>>();
    constexpr float kTurn = 0.314159265F;
    for (int k = 0; k <= 40; ++k) {
        for (int i = 0; i <= 40; ++i) {
            heights->push_back(0.7F * (1.0F - std::cos(kTurn * 0.5F * static_cast<float>(i))) *
                               (1.0F - std::cos(kTurn * 0.5F * static_cast<float>(k))));
        }
    }
    motion::StaticSurface surface;
    const motion::HeightGrid grid{41, 41, 0.5F, 0.5F, 1.0F, *heights};
    surface.surface = std::make_shared<motion::Surface>(grid, heights);
    const motion::StaticGeometry world({}, -20.0F, 16.0F, {surface});
    const auto mesh = Navmesh::bake(world, kPerson, kTwentyMetres);
    ASSERT_TRUE(mesh.ok());
    for (float z = -8.0F; z <= 8.0F; z += 0.37F) {
        for (float x = -8.0F; x <= 8.0F; x += 0.37F) {
            const float height = 0.7F * (1.0F - std::cos(kTurn * (x + 10.0F))) *
                                 (1.0F - std::cos(kTurn * (z + 10.0F)));
            Vec3 on;
            ASSERT_NE(mesh->nearest(Vec3(x, height, z), 0.5F, 100.0F, on), Navmesh::kNone);
            EXPECT_EQ(Vec2(on.x(), on.z()), Vec2(x, z));
            // The error allowed every metre; columns of 0.25 m stand as high as their highest place
            // (slopes of up to 0.44); two steps; and the error of a chord of 1 m along an arc.
            EXPECT_NEAR(on.y(), height, 0.2F + 0.11F + 0.1F + 0.05F);
        }
    }
}

TEST(Navmesh, FollowsHeights) {
    const auto heights = std::make_shared<std::vector<float>>();
    for (int k = 0; k <= 40; ++k) {
        for (int i = 0; i <= 40; ++i) {
            heights->push_back(5.0F + std::sin(0.3F * static_cast<float>(i)) +
                               (std::abs(i - 20) < 2 && std::abs(k - 20) < 15 ? 4.0F : 0.0F));
        }
    }
    motion::StaticSurface surface;
    surface.surface = std::make_shared<motion::Surface>(
        motion::HeightGrid{41, 41, 0.5F, 0.5F, 1.0F, *heights}, heights);
    const motion::StaticGeometry world({}, -20.0F, 16.0F, {surface});
    const auto mesh = Navmesh::bake(world, kPerson, kTwentyMetres);
    ASSERT_TRUE(mesh.ok());
    NavmeshSearch search;
    // Around the ridge: it ends 7.5 m from the middle.
    const NavmeshSearch::NavmeshAnswer a =
        search.plan(*mesh, Vec3(-5.0F, 5.0F, 0.0F), Vec3(5.0F, 5.0F, 0.0F), 2.0F);
    ASSERT_EQ(a.outcome, PathOutcome::kFound);
    EXPECT_GT(a.length_m, 2.0F * std::hypot(5.0F, 7.0F));
    EXPECT_LT(a.length_m, 30.0F);
    EXPECT_LT(off_mesh(*mesh, search.corners()), 0.05F);
    for (const Vec3& v : mesh->vertices()) {
        EXPECT_GT(v.y(), 3.5F);  // no agent walks on the plane far below
    }
}

TEST(NavmeshSearch, LeadsAlongTheMeshByWaysNoLongerThanThoseOfTheGrid) {
    core::Rng rng(61);
    double sum = 0.0;
    double sum_grid = 0.0;
    int compared = 0;
    for (int i = 0; i < 6; ++i) {
        std::vector<motion::StaticBox> boxes;
        for (int k = 0; k < 14; ++k) {
            boxes.push_back(static_box(Vec3(rng.range(-9, 9), 1.5F, rng.range(-9, 9)),
                                       Vec3(rng.range(0.3F, 3.0F), 1.5F, 0.2F),
                                       rng.range(0, 180)));
        }
        const motion::StaticGeometry world(boxes, 0.0F);
        const auto mesh = Navmesh::bake(world, kPerson, kTwentyMetres);
        ASSERT_TRUE(mesh.ok());
        const GroundMap ground = bake_ground(world, kPerson, kTwentyMetres, 0.25F);
        GridPlanner planner(ground.cells);
        NavmeshSearch search;
        for (int k = 0; k < 60; ++k) {
            GridQuery q;
            Cell goal;
            ASSERT_TRUE(nearest_passable(
                ground.cells, ground.grid, {rng.range(-9, 9), rng.range(-9, 9)}, 40, q.start));
            ASSERT_TRUE(nearest_passable(
                ground.cells, ground.grid, {rng.range(-9, 9), rng.range(-9, 9)}, 40, goal));
            q.goal = goal;
            const Spot from = ground.grid.centre(q.start);
            const Spot to = ground.grid.centre(q.goal);
            const GridAnswer best = planner.plan(q);
            const NavmeshSearch::NavmeshAnswer a =
                search.plan(*mesh, Vec3(from.x, 0, from.z), Vec3(to.x, 0, to.z), 0.6F);
            if (best.outcome != PathOutcome::kFound || a.outcome != PathOutcome::kFound) {
                continue;  // gaps of about a cell are open on the one and shut on the other
            }
            ASSERT_LT(off_mesh(*mesh, search.corners()), 0.05F);
            ++compared;
            sum += a.length_m;
            sum_grid += best.length * 0.25;
        }
    }
    EXPECT_GT(compared, 200);
    // Paths on the grid are longer by up to 8 % as they keep to eight directions; the corridor by
    // middles of edges may lose as much.
    EXPECT_LT(sum, 1.08 * sum_grid);
}

TEST(NavmeshSearch, NamesWhatCantBeAnsweredAndAllocatesNothingOnceWarm) {
    const Navmesh mesh = mesh_of({static_box(Vec3(0.0F, 1.5F, 0.0F), Vec3(0.2F, 1.5F, 9.9F))});
    EXPECT_EQ(outcome_of(mesh, Vec3(-30, 0, 0), Vec3(8, 0, 0)), PathOutcome::kStartBlocked);
    EXPECT_EQ(outcome_of(mesh, Vec3(-8, 0, 0), Vec3(8, 9, 0)), PathOutcome::kGoalBlocked);
    EXPECT_EQ(outcome_of(mesh, Vec3(-8, 0, 0), Vec3(8, 0, 0)), PathOutcome::kUnreachable);
    NavmeshSearch search;
    EXPECT_EQ(search.plan(mesh, Vec3(-8, 0, 0), Vec3(-2, 0, 3), 1.0F, 0).outcome,
              PathOutcome::kCutOff);
    for (int round = 0; round < 2; ++round) {
        const std::uint64_t before = allocation_count();
        for (int i = 0; i < 50; ++i) {
            search.plan(
                mesh, Vec3(-8, 0, -9.0F + 0.3F * static_cast<float>(i)), Vec3(-2, 0, 3), 1.0F);
        }
        EXPECT_TRUE(round == 0 || allocation_count() == before);
    }
}

TEST(Navmesh, SaysWhyItCantBeBaked) {
    const motion::StaticGeometry flat({}, 0.0F);
    const auto why = [&](const motion::StaticGeometry& world, GroundRect area, NavmeshSettings s) {
        const auto mesh = Navmesh::bake(world, kPerson, area, s);
        return mesh ? std::string("fine") : mesh.error();
    };
    EXPECT_EQ(why(flat, kTwentyMetres, {}), "fine");
    EXPECT_THAT(why(flat, kTwentyMetres, {0.0F, 0.05F}), testing::HasSubstr("size above 0"));
    EXPECT_THAT(why(flat, kTwentyMetres, {0.25F, 0.0F}), testing::HasSubstr("steps of height"));
    EXPECT_THAT(why(flat, {0.0F, 0.0F, 9000.0F, 1.0F}, {1.0F, 0.1F}), testing::HasSubstr("8192"));
    const motion::StaticGeometry tower({static_box(Vec3(0, 500, 0), Vec3(1, 500, 1))}, 0.0F);
    EXPECT_THAT(why(tower, kTwentyMetres, {}), testing::HasSubstr("steps of 0.05"));
    // A ground that is all wall has no polygons, and no paths.
    const auto none =
        Navmesh::bake(motion::StaticGeometry({static_box(Vec3(0, 5, 0), Vec3(20, 5, 20))}, 0.0F),
                      kPerson,
                      {-1.0F, -1.0F, 1.0F, 1.0F});
    Vec3 on;
    EXPECT_TRUE(!none || none->nearest(Vec3::Zero(), 1.0F, on) == Navmesh::kNone);
}

}  // namespace

}  // namespace zoned::ai::pathfinding
