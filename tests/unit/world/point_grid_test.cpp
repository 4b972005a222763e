#include "server/spatial/point_grid.h"

#include "shared/core/rng.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <vector>

namespace zoned::spatial {
namespace {

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
constexpr float kInf = std::numeric_limits<float>::infinity();

std::vector<std::uint32_t> brute(const std::vector<Vec3>& points, float x, float z, float radius) {
    std::vector<std::uint32_t> rows;
    for (std::uint32_t i = 0; i < points.size(); ++i) {
        const float dx = points[i].x() - x;
        const float dz = points[i].z() - z;
        if (std::isfinite(points[i].x()) && std::isfinite(points[i].z()) &&
            dx * dx + dz * dz <= radius * radius) {
            rows.push_back(i);
        }
    }
    return rows;
}

std::vector<std::uint32_t> ask(const PointGrid& grid, float x, float z, float radius) {
    std::vector<std::uint32_t> rows;
    grid.for_each_within(x, z, radius, [&](std::uint32_t row, float d2) {
        EXPECT_LE(d2, radius * radius);
        rows.push_back(row);
    });
    return rows;
}

void expect_brute_force(const PointGrid& grid,
                        const std::vector<Vec3>& points,
                        float x,
                        float z,
                        float radius) {
    std::vector<std::uint32_t> rows = ask(grid, x, z, radius);
    std::sort(rows.begin(), rows.end());
    ASSERT_EQ(rows, brute(points, x, z, radius)) << x << " " << z << " " << radius;
}

TEST(PointGrid, EqualsBruteForceOnRandomPoints) {
    core::Rng rng(1);
    PointGrid grid;
    for (const float offset : {0.0F, 1000.0F, -30000.0F}) {
        for (const float cell : {0.5F, 7.3F, 50.0F, 5000.0F}) {
            std::vector<Vec3> points(rng.below(800));
            for (Vec3& p : points) {
                p = Vec3(offset + rng.range(-100, 100), rng.range(0, 50), rng.range(-100, 100));
            }
            grid.build(points, cell);
            ASSERT_EQ(grid.size(), points.size());
            for (int i = 0; i < 200; ++i) {
                expect_brute_force(grid,
                                   points,
                                   offset + rng.range(-150, 150),
                                   rng.range(-150, 150),
                                   rng.range(0, 60));
            }
        }
    }
}

TEST(PointGrid, EqualsBruteForceWhereDistancesLieExactlyOnTheRadiusAndOnCellBorders) {
    core::Rng rng(2);
    PointGrid grid;
    std::vector<Vec3> points;
    for (int i = 0; i < 600; ++i) {
        points.emplace_back(0.25F * static_cast<float>(rng.below(400)),
                            0.0F,
                            0.25F * static_cast<float>(rng.below(400)));
    }
    grid.build(points, 1.0F);
    for (int i = 0; i < 2000; ++i) {
        const Vec3& p = points[rng.below(600)];
        const float radius = 0.25F * static_cast<float>(rng.below(80));
        expect_brute_force(grid, points, p.x() + radius, p.z(), radius);
        expect_brute_force(grid, points, p.x(), p.z() - radius, radius);
        // A radius that a float cannot hold exactly, from far away.
        expect_brute_force(grid, points, p.x() + 1000.1F, p.z(), 1000.1F);
    }
}

TEST(PointGrid, LeavesOutPointsThatAreNotFinite) {
    const std::vector<Vec3> points = {
        Vec3(kNan, 0, 0), Vec3(1, 0, 1), Vec3(0, 0, kInf), Vec3(-kInf, 0, 0), Vec3(2, kNan, 2)};
    PointGrid grid;
    grid.build(points, 1.0F);
    // The height plays no part.
    EXPECT_EQ(grid.size(), 2U);
    expect_brute_force(grid, points, 0, 0, 100);
}

TEST(PointGrid, HoldsNothingOnePointAndManyInOnePlace) {
    PointGrid grid;
    grid.build({}, 1.0F);
    EXPECT_TRUE(ask(grid, 0, 0, 1e9F).empty());

    const std::vector<Vec3> one = {Vec3(3, 0, -4)};
    grid.build(one, 1.0F);
    EXPECT_EQ(ask(grid, 0, 0, 5), std::vector<std::uint32_t>({0}));
    EXPECT_TRUE(ask(grid, 0, 0, 4.999F).empty());

    const std::vector<Vec3> same(1000, Vec3(3, 0, -4));
    grid.build(same, 1.0F);
    EXPECT_EQ(ask(grid, 3, -4, 0).size(), 1000U);
    EXPECT_TRUE(ask(grid, 3.01F, -4, 0.001F).empty());

    grid.build({}, 1.0F);
    EXPECT_TRUE(ask(grid, 3, -4, 10).empty());
}

TEST(PointGrid, KeepsItsSizeInBoundsWithFarOutliers) {
    core::Rng rng(3);
    for (const float far : {1e6F, 1e12F, 3e38F}) {
        std::vector<Vec3> points;
        for (int i = 0; i < 200; ++i) {
            points.emplace_back(rng.range(-50, 50), 0.0F, rng.range(-50, 50));
        }
        points.emplace_back(far, 0.0F, -far);
        points.emplace_back(-far, 0.0F, far);
        PointGrid grid;
        grid.build(points, 1.0F);
        for (int i = 0; i < 50; ++i) {
            expect_brute_force(grid, points, rng.range(-60, 60), rng.range(-60, 60), 20);
        }
        expect_brute_force(grid, points, far, -far, 1.0F);
        expect_brute_force(grid, points, 0, 0, kInf);
    }
}

TEST(PointGrid, FindsNothingForAQueryThatIsNoPlace) {
    const std::vector<Vec3> points = {Vec3(1, 0, 1), Vec3(2, 0, 2)};
    PointGrid grid;
    grid.build(points, 1.0F);
    EXPECT_TRUE(ask(grid, kNan, 0, 10).empty());
    EXPECT_TRUE(ask(grid, 0, kNan, 10).empty());
    EXPECT_TRUE(ask(grid, kInf, 0, 10).empty());
    EXPECT_TRUE(ask(grid, 1e30F, -1e30F, 10).empty());
    int visits = 0;
    grid.for_each_within(0, 0, kNan, [&](std::uint32_t, float) { ++visits; });
    EXPECT_EQ(visits, 0);
}

TEST(PointGrid, VisitsInTheSameOrderEveryTime) {
    core::Rng rng(4);
    std::vector<Vec3> points;
    for (int i = 0; i < 500; ++i) {
        points.emplace_back(rng.range(-50, 50), 0.0F, rng.range(-50, 50));
    }
    PointGrid fresh;
    fresh.build(points, 5.0F);
    PointGrid used;
    used.build(std::vector<Vec3>(2000, Vec3(9, 9, 9)), 0.1F);
    used.build(points, 5.0F);
    EXPECT_EQ(ask(fresh, 0, 0, 30), ask(used, 0, 0, 30));
}

/// Rows rest, move, come and go, as those of a zone do.
TEST(PointGrid, EqualsBruteForceWhileMostPointsAreKept) {
    core::Rng rng(7);
    PointGrid grid;
    std::vector<Vec3> points(500);
    const auto anywhere = [&] {
        return Vec3(rng.range(-100, 100), 0, rng.range(-100, 100));
    };
    for (Vec3& p : points) {
        p = anywhere();
    }
    std::vector<bool> loose(points.size(), true);
    for (int tick = 0; tick < 400; ++tick) {
        if (tick % 40 == 0) {
            std::vector<std::uint32_t> kept;
            for (std::uint32_t row = 0; row < points.size(); ++row) {
                loose[row] = rng.below(5) == 0;
                if (!loose[row]) {
                    kept.push_back(row);
                }
            }
            grid.keep(points, kept, 10.0F);
        }
        for (int k = 0; k < 5; ++k) {
            const std::uint32_t row = rng.below(static_cast<std::uint32_t>(points.size()));
            points[row] = anywhere();
            loose[row] = true;
        }
        if (rng.below(2) == 0) {
            const std::uint32_t gap = rng.below(static_cast<std::uint32_t>(points.size()));
            points[gap] = points.back();
            loose[gap] = true;
            points.pop_back();
            loose.pop_back();
        } else if (rng.below(2) == 0) {
            points.push_back(anywhere());
            loose.push_back(true);
        }
        std::vector<std::uint32_t> rows;
        for (std::uint32_t row = 0; row < points.size(); ++row) {
            if (loose[row]) {
                rows.push_back(row);
            }
        }
        grid.follow(points, rows, 10.0F);
        EXPECT_EQ(grid.size(), points.size());
        for (int k = 0; k < 10; ++k) {
            expect_brute_force(
                grid, points, rng.range(-110, 110), rng.range(-110, 110), rng.range(0, 60));
        }
    }
    // A point that moved without notice is found at its old place: the comparison would see it.
    const std::vector<std::uint32_t> none;
    std::vector<std::uint32_t> all(points.size());
    for (std::uint32_t row = 0; row < points.size(); ++row) {
        all[row] = row;
    }
    grid.keep(points, all, 10.0F);
    points[3] += Vec3(50, 0, 0);
    grid.follow(points, none, 10.0F);
    const std::vector<std::uint32_t> found = ask(grid, points[3].x(), points[3].z(), 0.1F);
    EXPECT_EQ(std::count(found.begin(), found.end(), 3U), 0);
}

}  // namespace
}  // namespace zoned::spatial
