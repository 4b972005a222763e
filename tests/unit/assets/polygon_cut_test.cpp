// Polygons cut up: all of the area, none of it twice, and every triangle faces as the polygon does.
#include "server/assets/polygon_cut.h"

#include "shared/core/rng.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace zoned::assets {
namespace {

Vec3d area(const Vec3& a, const Vec3& b, const Vec3& c) {
    return 0.5 * (b - a).cast<double>().cross((c - a).cast<double>());
}

/// Area of a flat polygon as a vector along its normal.
Vec3d area(const std::vector<Vec3>& p) {
    Vec3d sum = Vec3d::Zero();
    for (std::size_t i = 1; i + 1 < p.size(); ++i) {
        sum += area(p[0], p[i], p[i + 1]);
    }
    return sum;
}

/// The triangles' areas add up to the polygon's, and none faces the opposite direction. Corners are
/// floats of size 1: an area is off by 1e-7 at most for each triangle.
void expect_cut(const std::vector<Vec3>& polygon) {
    std::vector<std::array<std::uint32_t, 3>> cut;
    ASSERT_TRUE(cut_polygon(polygon, cut));
    ASSERT_EQ(cut.size(), polygon.size() - 2);
    const Vec3d whole = area(polygon);
    double sum = 0.0;
    for (const auto& t : cut) {
        const double part =
            area(polygon[t[0]], polygon[t[1]], polygon[t[2]]).dot(whole.normalized());
        EXPECT_GE(part, -1.0e-7);
        sum += part;
    }
    EXPECT_NEAR(sum, whole.norm(), 1.0e-7 * static_cast<double>(polygon.size()));
}

/// Turned so that no axis is its normal.
std::vector<Vec3> tilted(const std::vector<Vec2>& outline) {
    const Quat turn(Eigen::AngleAxisf(0.7F, Vec3(1.0F, 2.0F, -0.5F).normalized()));
    std::vector<Vec3> out;
    for (const Vec2& p : outline) {
        out.push_back(turn * Vec3(p.x(), 0.0F, p.y()));
    }
    return out;
}

TEST(PolygonCut, CutsStarsOfAnyRoughnessEitherWayRound) {
    core::Rng rng(21);
    for (int round = 0; round < 300; ++round) {
        const std::uint32_t n = 4 + rng.below(253);
        std::vector<Vec2> outline;
        for (std::uint32_t i = 0; i < n; ++i) {
            const float angle =
                2.0F * std::numbers::pi_v<float> * static_cast<float>(i) / static_cast<float>(n);
            const float radius = rng.range(0.1F, 1.0F);
            outline.emplace_back(radius * std::cos(angle), radius * std::sin(angle));
        }
        if (round % 2 == 0) {
            std::reverse(outline.begin(), outline.end());
        }
        SCOPED_TRACE(round);
        expect_cut(tilted(outline));
    }
}

TEST(PolygonCut, CutsCombsAndSpiralsWhereFewCornersAreEars) {
    std::vector<Vec2> comb;
    for (int i = 0; i < 60; ++i) {
        comb.emplace_back(0.01F * static_cast<float>(i), i % 2 == 0 ? 0.0F : 0.9F);
    }
    comb.emplace_back(0.6F, -0.1F);
    comb.emplace_back(0.0F, -0.1F);
    expect_cut(tilted(comb));
    std::vector<Vec2> spiral;
    for (const float inset : {0.0F, 0.02F}) {
        std::vector<Vec2> side;
        for (int i = 0; i < 80; ++i) {
            const float angle = 0.2F * static_cast<float>(i);
            const float radius = 1.0F - 0.01F * static_cast<float>(i) - inset;
            side.emplace_back(radius * std::cos(angle), radius * std::sin(angle));
        }
        if (inset > 0.0F) {
            std::reverse(side.begin(), side.end());
        }
        spiral.insert(spiral.end(), side.begin(), side.end());
    }
    expect_cut(tilted(spiral));
}

TEST(PolygonCut, KeepsCornersThatCoincideOrLieInALine) {
    expect_cut(tilted({{0, 0}, {0.5F, 0}, {1, 0}, {1, 1}, {1, 1}, {0, 1}, {0, 0.25F}}));
    // A square with a square hole, joined by a bridge that is walked there and back.
    expect_cut(tilted({{0, 0},
                       {1, 0},
                       {1, 1},
                       {0, 1},
                       {0, 0},
                       {0.25F, 0.25F},
                       {0.25F, 0.75F},
                       {0.75F, 0.75F},
                       {0.75F, 0.25F},
                       {0.25F, 0.25F}}));
    std::vector<std::array<std::uint32_t, 3>> cut;
    EXPECT_TRUE(cut_polygon(std::vector<Vec3>(6, Vec3(1, 2, 3)), cut));  // all in one place
}

TEST(PolygonCut, TakesTheShorterDiagonalOfAQuadrilateralThatLiesWithin) {
    const auto first_of = [](const std::vector<Vec2>& outline) {
        std::vector<std::array<std::uint32_t, 3>> cut;
        EXPECT_TRUE(cut_polygon(tilted(outline), cut));
        return cut[0];
    };
    using Corners = std::array<std::uint32_t, 3>;
    EXPECT_EQ(first_of({{0, 0}, {1, 0}, {1, 1}, {0, 1}}), (Corners{0, 1, 2}));
    EXPECT_EQ(first_of({{0, 0}, {1, 0}, {2, 2}, {0, 1}}), (Corners{3, 0, 1}));
    // An arrow head: the longer diagonal is the one that lies within.
    EXPECT_EQ(first_of({{0, 0}, {3, -1}, {1, 0}, {3, 1}}), (Corners{0, 1, 2}));
    expect_cut(tilted({{0, 0}, {0.3F, -0.1F}, {0.1F, 0}, {0.3F, 0.1F}}));
}

TEST(PolygonCut, SaysWhenAnOutlineCrossesItself) {
    std::vector<std::array<std::uint32_t, 3>> cut;
    EXPECT_FALSE(cut_polygon(tilted({{0, 0}, {1, 1}, {1, 0}, {0, 1.5F}}), cut));
}

}  // namespace
}  // namespace zoned::assets
