// build: computes
// Surfaces: nearby triangles, heights, and how characters walk on surfaces and are stopped.
#include "shared/core/rng.h"
#include "shared/math/segment_triangle.h"
#include "shared/motion/apply_input.h"
#include "shared/motion/capsule_sweep.h"
#include "shared/motion/ground_surface.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>

namespace zoned::motion {
namespace {

constexpr float kTickS = 1.0F / 30.0F;
constexpr float kFloor = 0.9F;  // of a default character's centre above its ground

Vec3 random_point(core::Rng& rng, float extent) {
    return {rng.range(-extent, extent), rng.range(-extent, extent), rng.range(-extent, extent)};
}

FacedTriangle random_triangle(core::Rng& rng) {
    for (;;) {
        FacedTriangle t;
        t.corner = {random_point(rng, 2.0F), random_point(rng, 2.0F), random_point(rng, 2.0F)};
        const Vec3 cross = (t.corner[1] - t.corner[0]).cross(t.corner[2] - t.corner[0]);
        if (cross.norm() > 0.1F) {
            t.normal = cross.normalized();
            return t;
        }
    }
}

/// Calls visit(point) for points all over a triangle, no farther apart than `edge` / n.
void for_points(const FacedTriangle& t, int n, const std::function<void(const Vec3&)>& visit) {
    for (int a = 0; a <= n; ++a) {
        for (int b = 0; a + b <= n; ++b) {
            visit(t.corner[0] +
                  (t.corner[1] - t.corner[0]) * (static_cast<float>(a) / static_cast<float>(n)) +
                  (t.corner[2] - t.corner[0]) * (static_cast<float>(b) / static_cast<float>(n)));
        }
    }
}

TEST(SegmentTriangleDistance, IsTheLeastOverAllPointsOfBoth) {
    core::Rng rng(5);
    int apart = 0;
    for (int round = 0; round < 300; ++round) {
        const FacedTriangle t = random_triangle(rng);
        const Vec3 middle = random_point(rng, 1.5F);
        const Vec3 half = random_point(rng, 1.0F);
        const SegmentTriangleDistance found = segment_triangle_distance(middle, half, t);
        // Sampled points lie within half a step of the closest ones on both sides: edges are at
        // most 4 sqrt(3) = 6.93 m, halves sqrt(3) m long.
        constexpr int kN = 30;
        float least = INFINITY;
        for_points(t, kN, [&](const Vec3& p) {
            for (int s = -kN; s <= kN; ++s) {
                const Vec3 q = middle + half * (static_cast<float>(s) / kN);
                least = std::min(least, (p - q).norm());
            }
        });
        if (found.distance > 0.0F) {
            ++apart;
            EXPECT_LE(found.distance, least + 1e-4F);
            EXPECT_GE(found.distance, least - 6.93F / kN - 1.74F / kN);
            // Moved along the normal by d, the distance grows by as much: it is the gradient.
            const auto farther = segment_triangle_distance(middle + found.normal * 0.1F, half, t);
            EXPECT_NEAR(farther.distance, found.distance + 0.1F, 2e-4F);
        } else {
            EXPECT_LT(least, 6.93F / kN + 1.74F / kN);
            // Moved out along the triangle's normal by as much as it says, no end is behind the
            // plane: they are apart.
            const auto out =
                segment_triangle_distance(middle - t.normal * (found.distance - 1e-3F), half, t);
            EXPECT_GT(out.distance, 5e-4F);
        }
    }
    EXPECT_GT(apart, 100);
    EXPECT_LT(apart, 300);
}

TEST(BoxTriangleOverlap, AgreesWithPointsOfTheTriangle) {
    core::Rng rng(6);
    int overlaps = 0;
    int held = 0;
    for (int round = 0; round < 2000; ++round) {
        const FacedTriangle t = random_triangle(rng);
        const Vec3 centre = random_point(rng, 2.0F);
        const Vec3 half(rng.range(0.1F, 1.0F), rng.range(0.1F, 1.0F), rng.range(0.1F, 1.0F));
        // The least distance from the box over sampled points; a step is at most 6.93 / 50 m.
        float least = INFINITY;
        for_points(t, 50, [&](const Vec3& p) {
            least = std::min(least, ((p - centre).cwiseAbs() - half).cwiseMax(0.0F).norm());
        });
        const bool overlap = box_triangle_overlap(centre, half, t);
        overlaps += overlap ? 1 : 0;
        if (least == 0.0F) {
            EXPECT_TRUE(overlap);
            ++held;
        }
        if (overlap) {
            EXPECT_LT(least, 6.93F / 50.0F);
        }
    }
    EXPECT_GT(held, 200);
    EXPECT_LT(overlaps, 1800);
}

/// A surface with the tables that it reads.
struct Tables {
    std::vector<float> heights;
    std::vector<Vec3> vertices;
    std::vector<std::array<std::uint32_t, 3>> corners;
};

std::shared_ptr<const Surface> heights_of(std::uint32_t n,
                                          float spacing,
                                          const std::function<float(float, float)>& f,
                                          float thickness = 1.0F) {
    auto tables = std::make_shared<Tables>();
    const float half = 0.5F * static_cast<float>(n - 1);
    for (std::uint32_t k = 0; k < n; ++k) {
        for (std::uint32_t i = 0; i < n; ++i) {
            tables->heights.push_back(f((static_cast<float>(i) - half) * spacing,
                                        (static_cast<float>(k) - half) * spacing));
        }
    }
    return std::make_shared<const Surface>(
        HeightGrid{n, n, spacing, spacing, thickness, tables->heights}, tables);
}

std::shared_ptr<const Surface> mesh_of(std::vector<Vec3> vertices,
                                       std::vector<std::array<std::uint32_t, 3>> corners) {
    auto tables = std::make_shared<Tables>();
    tables->vertices = std::move(vertices);
    tables->corners = std::move(corners);
    return std::make_shared<const Surface>(TriangleList{tables->vertices, tables->corners}, tables);
}

/// All triangles of a surface as a mesh.
std::shared_ptr<const Surface> as_mesh(const Surface& surface) {
    std::vector<Vec3> vertices;
    std::vector<std::array<std::uint32_t, 3>> corners;
    surface.for_each_near(surface.box(), [&](const FacedTriangle& t) {
        const auto first = static_cast<std::uint32_t>(vertices.size());
        vertices.insert(vertices.end(), t.corner.begin(), t.corner.end());
        corners.push_back({first, first + 1, first + 2});
    });
    return mesh_of(std::move(vertices), std::move(corners));
}

float hills(float x, float z) {
    return 3.0F * std::sin(0.3F * x) * std::cos(0.25F * z) + 3.0F;
}

StaticGeometry world_of(const std::shared_ptr<const Surface>& surface,
                        const Vec3& position = Vec3::Zero(),
                        float yaw = 0.0F,
                        float ground = -50.0F) {
    const Quat turned(Eigen::AngleAxisf(yaw, Vec3::UnitY()));
    return StaticGeometry({}, ground, 16.0F, {{surface, position, turned}});
}

TEST(Surface, VisitsExactlyTheTrianglesWhoseBoundsOverlapOnce) {
    core::Rng rng(7);
    for (const int count : {1, 10, 400}) {
        std::vector<Vec3> vertices;
        std::vector<std::array<std::uint32_t, 3>> corners;
        for (int i = 0; i < count; ++i) {
            const Vec3 at = random_point(rng, 30.0F);
            const float size = i % 7 == 0 ? 40.0F : 2.0F;  // some are far larger than a cell
            const auto first = static_cast<std::uint32_t>(vertices.size());
            for (int c = 0; c < 3; ++c) {
                vertices.emplace_back(at + random_point(rng, size));
            }
            corners.push_back({first, first + 1, first + 2});
        }
        const auto surface = mesh_of(vertices, corners);
        for (int round = 0; round < 200; ++round) {
            const Vec3 lower = random_point(rng, 40.0F);
            const Aabb area{lower, lower + random_point(rng, 8.0F).cwiseAbs()};
            std::vector<int> visits(static_cast<std::size_t>(count), 0);
            surface->for_each_near(area, [&](const FacedTriangle& t) {
                for (std::size_t i = 0; i < visits.size(); ++i) {
                    visits[i] += vertices[3 * i] == t.corner[0] ? 1 : 0;
                }
            });
            for (std::size_t i = 0; i < visits.size(); ++i) {
                const Aabb bounds{
                    vertices[3 * i].cwiseMin(vertices[3 * i + 1]).cwiseMin(vertices[3 * i + 2]),
                    vertices[3 * i].cwiseMax(vertices[3 * i + 1]).cwiseMax(vertices[3 * i + 2])};
                EXPECT_EQ(visits[i], bounds.overlaps(area) ? 1 : 0);
            }
        }
    }
}

TEST(Surface, IndexesTrianglesThatAllLieOverEachOtherInTimeAndMemoryThatGrowWithTheirNumber) {
    // Each covers the whole square: with cells for small ones this would take n^2 entries, 40 GB.
    std::vector<Vec3> vertices;
    std::vector<std::array<std::uint32_t, 3>> corners;
    for (std::uint32_t i = 0; i < 100000; ++i) {
        const float y = 0.001F * static_cast<float>(i);
        vertices.insert(vertices.end(), {{-9, y, -9}, {0, y, 9}, {9, y, -9}});
        corners.push_back({3 * i, 3 * i + 1, 3 * i + 2});
    }
    const auto surface = mesh_of(std::move(vertices), std::move(corners));
    ASSERT_TRUE(surface->top_at(0.0F, 0.0F).has_value());
    EXPECT_FLOAT_EQ(*surface->top_at(0.0F, 0.0F), 99.999F);
}

TEST(Surface, KnowsHowHighItIsAndWhatLiesBehind) {
    const auto grid = heights_of(41, 1.0F, [](float x, float z) { return 0.5F * x - 0.25F * z; });
    const auto mesh = as_mesh(*grid);
    core::Rng rng(8);
    for (int round = 0; round < 500; ++round) {
        const float x = rng.range(-19.9F, 19.9F);
        const float z = rng.range(-19.9F, 19.9F);
        for (const auto& surface : {grid, mesh}) {
            const auto top = surface->top_at(x, z);
            ASSERT_TRUE(top.has_value());
            EXPECT_NEAR(*top, 0.5F * x - 0.25F * z, 1e-4F);  // a plane: rounding alone
            EXPECT_TRUE(surface->behind({x, *top - 0.1F, z}));
            EXPECT_FALSE(surface->behind({x, *top + 0.1F, z}));
        }
    }
    EXPECT_FALSE(grid->top_at(20.5F, 0.0F).has_value());
    // Heights end `thickness` below the lowest sample, -15 m here; a mesh is solid behind for ever.
    EXPECT_TRUE(grid->behind({0.0F, -15.9F, 0.0F}));
    EXPECT_FALSE(grid->behind({0.0F, -16.1F, 0.0F}));
    EXPECT_TRUE(mesh->behind({0.0F, -16.1F, 0.0F}));
}

/// Lets a character fall to rest.
CharacterState land(const StaticGeometry& world, const Vec3& from) {
    CharacterState state;
    state.position = from;
    for (int i = 0; i < 120 && !(state.grounded && state.velocity.isZero(0.0F)); ++i) {
        state = apply_input(state, {}, {}, world, kTickS);
    }
    EXPECT_TRUE(state.grounded);
    return state;
}

InputCommand towards(float x, float z) {
    InputCommand command;
    command.move_x = static_cast<std::int8_t>(std::lround(127.0F * x));
    command.move_z = static_cast<std::int8_t>(std::lround(127.0F * z));
    return command;
}

TEST(WalkOnSurface, KeepsFullSpeedAndHeightOverTheEdgesOfAFlatOne) {
    const auto flat = heights_of(65, 1.0F, [](float, float) { return 2.0F; });
    for (const auto& surface : {flat, as_mesh(*flat)}) {
        const StaticGeometry world = world_of(surface, Vec3(0.3F, 0.0F, 0.7F), 0.4F);
        CharacterState state = land(world, Vec3(-12.0F, 3.5F, -8.0F));
        for (int tick = 0; tick < 120; ++tick) {
            const Vec3 before = state.position;
            state = apply_input(state, towards(0.8F, 0.6F), {}, world, kTickS);
            ASSERT_TRUE(state.grounded) << tick;
            // A millimetre of air is kept, and a graze may use some of it up.
            EXPECT_NEAR(state.position.y(), 2.0F + kFloor + kSkin, 2.0F * kSkin);
            if (tick > 10) {
                EXPECT_NEAR(
                    (state.position - before).norm(), 5.0F * kTickS, 0.005F * 5.0F * kTickS);
            }
        }
    }
}

TEST(WalkOnSurface, ClimbsASlopeThatCarriesAndSlidesDownOneThatDoesNot) {
    const auto slope = [](float degrees) {
        const float rise = std::tan(degrees * 0.0174533F);
        return heights_of(65, 1.0F, [rise](float x, float) { return rise * x; });
    };
    const StaticGeometry gentle = world_of(slope(25.0F));
    CharacterState state = land(gentle, Vec3(-10.0F, 0.0F, 0.5F));
    const Vec3 begin = state.position;
    for (int tick = 0; tick < 60; ++tick) {
        state = apply_input(state, towards(1.0F, 0.0F), {}, gentle, kTickS);
        ASSERT_TRUE(state.grounded);
    }
    // Two seconds at 5 m/s, less v^2 / 2a = 0.625 m until full speed.
    EXPECT_NEAR(state.position.x() - begin.x(), 9.375F, 0.1F);
    EXPECT_NEAR(state.position.y() - begin.y(),
                (state.position.x() - begin.x()) * std::tan(25.0F * 0.0174533F),
                0.01F);
    const StaticGeometry steep = world_of(slope(60.0F));
    CharacterState sliding;
    sliding.position = Vec3(0.0F, 2.0F, 0.0F);
    for (int tick = 0; tick < 60; ++tick) {
        sliding = apply_input(sliding, {}, {}, steep, kTickS);
    }
    EXPECT_LT(sliding.position.x(), -3.0F);
}

TEST(WalkOnSurface, NeverSinksIntoHillsWhateverTheWay) {
    const auto grid = heights_of(81, 0.75F, hills);
    for (const auto& surface : {grid, as_mesh(*grid)}) {
        const StaticGeometry world = world_of(surface, Vec3(1.0F, -2.0F, 3.0F), 1.1F);
        const PlacedSurface& placed = world.surfaces()[0];
        core::Rng rng(9);
        CharacterState state = land(world, Vec3(0.0F, 8.0F, 0.0F));
        int grounded = 0;
        float wish_x = 1.0F;
        float wish_z = 0.0F;
        for (int tick = 0; tick < 3000; ++tick) {
            if (tick % 20 == 0) {
                const bool back = state.position.norm() > 18.0F;
                wish_x = back ? -state.position.x() / 30.0F : rng.range(-1.0F, 1.0F);
                wish_z = back ? -state.position.z() / 30.0F : rng.range(-1.0F, 1.0F);
            }
            InputCommand command = towards(wish_x, wish_z);
            command.buttons = tick % 90 == 7 ? kButtonJump : kButtonSprint;
            state = apply_input(state, command, {}, world, kTickS);
            grounded += state.grounded ? 1 : 0;
            // No triangle comes nearer to the capsule than its radius, less the loss by a graze.
            float nearest = INFINITY;
            const Vec3 local = placed.to_local(state.position);
            surface->for_each_near(Aabb{local, local}.grown(1.0F), [&](const FacedTriangle& t) {
                nearest = std::min(
                    nearest, segment_triangle_distance(local, Vec3(0.0F, 0.5F, 0.0F), t).distance);
            });
            ASSERT_GT(nearest, 0.4F) << tick;
            ASSERT_FALSE(surface->behind(local)) << tick;
        }
        EXPECT_GT(grounded, 1500);
    }
}

/// A block of a mesh, closed, with its middle at the origin.
std::shared_ptr<const Surface> block(const Vec3& half) {
    std::vector<Vec3> v;
    for (int i = 0; i < 8; ++i) {
        v.emplace_back((i & 1) != 0 ? half.x() : -half.x(),
                       (i & 2) != 0 ? half.y() : -half.y(),
                       (i & 4) != 0 ? half.z() : -half.z());
    }
    return mesh_of(v,
                   {{0, 2, 3},
                    {0, 3, 1},
                    {4, 5, 7},
                    {4, 7, 6},
                    {0, 4, 6},
                    {0, 6, 2},
                    {1, 3, 7},
                    {1, 7, 5},
                    {0, 1, 5},
                    {0, 5, 4},
                    {2, 6, 7},
                    {2, 7, 3}});
}

TEST(WalkOnSurface, IsStoppedByAMeshAsByABox) {
    const Vec3 half(0.5F, 2.0F, 6.0F);
    const StaticGeometry mesh = world_of(block(half), Vec3(3.0F, 1.0F, 0.0F), 0.0F, 0.0F);
    StaticBox box;
    box.centre = Vec3(3.0F, 1.0F, 0.0F);
    box.half_extents = half;
    const StaticGeometry boxes({box}, 0.0F);
    for (const float z : {0.0F, 0.4F, 0.8F}) {
        CharacterState a = land(mesh, Vec3(0.0F, 1.0F, 0.0F));
        CharacterState b = land(boxes, Vec3(0.0F, 1.0F, 0.0F));
        for (int tick = 0; tick < 40; ++tick) {
            a = apply_input(a, towards(0.6F, z), {}, mesh, kTickS);
            b = apply_input(b, towards(0.6F, z), {}, boxes, kTickS);
            EXPECT_LT(a.position.x(), 2.1F);
            EXPECT_LT((a.position - b.position).norm(), 0.005F) << tick;
        }
        EXPECT_GT(a.position.x(), 2.0F);
    }
}

TEST(WalkOnSurface, ClimbsALowLedgeOfAMeshAndNoHighOne) {
    for (const auto& [height, climbs] : {std::pair(0.2F, true), std::pair(0.8F, false)}) {
        const StaticGeometry world =
            world_of(block(Vec3(3.0F, height, 3.0F)), Vec3(5.0F, 0.0F, 0.0F), 0.0F, 0.0F);
        CharacterState state = land(world, Vec3(0.0F, 1.0F, 0.3F));
        for (int tick = 0; tick < 45; ++tick) {
            state = apply_input(state, towards(1.0F, 0.0F), {}, world, kTickS);
        }
        EXPECT_EQ(state.position.y() > height + kFloor - 0.01F, climbs) << height;
        EXPECT_EQ(state.position.x() > 3.0F, climbs) << height;
    }
}

TEST(WalkOnSurface, ComesUpOutOfHeights) {
    const StaticGeometry world = world_of(heights_of(33, 1.0F, [](float, float) { return 4.0F; }));
    CharacterState state;
    state.position = Vec3(1.0F, 3.2F, 1.0F);  // below, within the thickness
    state = apply_input(state, {}, {}, world, kTickS);
    EXPECT_NEAR(state.position.y(), 4.0F + kFloor, 0.01F);
    CharacterState under;  // deep below: there may be a room
    under.position = Vec3(1.0F, 1.0F, 1.0F);
    under = apply_input(under, {}, {}, world, kTickS);
    EXPECT_LT(under.position.y(), 1.0F);
}

}  // namespace
}  // namespace zoned::motion
