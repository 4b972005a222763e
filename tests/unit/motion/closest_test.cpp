// build: computes
#include "shared/math/closest.h"

#include "tests/unit/motion/random_vector.h"
#include "shared/core/rng.h"
#include "shared/math/aabb.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace zoned {
namespace {

/// The segment's distance to the box by golden section in double.
double brute_distance(const Vec3& middle, const Vec3& half, const Vec3& h) {
    const Vec3d hd = h.cast<double>();
    const auto at = [&](double t) {
        const Vec3d p = middle.cast<double>() + t * half.cast<double>();
        return (p - p.cwiseMax(-hd).cwiseMin(hd)).norm();
    };
    double lo = -1.0;
    double hi = 1.0;
    const double g = 1.0 / std::numbers::phi;
    for (int i = 0; i < 80; ++i) {
        const double a = hi - g * (hi - lo);
        const double b = lo + g * (hi - lo);
        if (at(a) < at(b)) {
            hi = b;
        } else {
            lo = a;
        }
    }
    return std::min({at(lo), at(-1.0), at(1.0)});
}

struct Case {
    Vec3 middle;
    Vec3 half;
    Vec3 h;
};

Case random_case(core::Rng& rng, float spread) {
    Case c;
    c.h = Vec3(rng.range(0.05F, 3), rng.range(0.05F, 3), rng.range(0.05F, 3));
    c.middle = random_vector(rng, spread);
    c.half = random_vector(rng, 2.0F);
    // Segments along an axis are the common case: upright characters among unrotated boxes.
    const std::uint32_t kind = rng.below(4);
    if (kind == 0) {
        c.half = Vec3(0.0F, rng.range(0.0F, 2.0F), 0.0F);
    } else if (kind == 1) {
        c.half[static_cast<int>(rng.below(3))] = 0.0F;
    } else if (kind == 2 && rng.below(8) == 0) {
        c.half = Vec3::Zero();
    }
    return c;
}

TEST(SegmentBoxDistance, EqualsBruteForceAnywhereOutside) {
    core::Rng rng(1);
    int outside = 0;
    for (int i = 0; i < 20000; ++i) {
        const Case c = random_case(rng, 5.0F);
        const double expected = brute_distance(c.middle, c.half, c.h);
        const SegmentBoxDistance got = segment_box_distance(c.middle, c.half, c.h);
        EXPECT_NEAR(got.normal.norm(), 1.0F, 1e-5F);
        if (expected > 1e-4) {
            ++outside;
            // Roundings of coordinates of up to 10 m, 2^-24 of which are 6e-7 m.
            ASSERT_NEAR(got.distance, expected, 4e-6);
        } else {
            ASSERT_LT(got.distance, 2e-4F);
        }
    }
    EXPECT_GT(outside, 10000);
}

TEST(SegmentBoxDistance, TheNormalSeparates) {
    core::Rng rng(2);
    for (int i = 0; i < 20000; ++i) {
        const Case c = random_case(rng, 5.0F);
        const SegmentBoxDistance got = segment_box_distance(c.middle, c.half, c.h);
        // On the normal the least coordinate of the segment less the largest of the box is the
        // distance, and minus the overlap where they intersect.
        const double least = got.normal.dot(c.middle) - std::abs(got.normal.dot(c.half));
        const double largest = got.normal.cwiseAbs().dot(c.h);
        // A direction between points that are d apart carries an error of rounding / d.
        const double allowed = 1e-5 + 2e-6 / std::max(1e-6, std::abs(double{got.distance}));
        ASSERT_NEAR(least - largest, got.distance, allowed);
    }
}

TEST(SegmentBoxDistance, MovesOutByTheLeastTranslationWhereTheyIntersect) {
    core::Rng rng(3);
    int inside = 0;
    for (int i = 0; i < 4000; ++i) {
        const Case c = random_case(rng, 2.0F);
        const SegmentBoxDistance got = segment_box_distance(c.middle, c.half, c.h);
        if (got.distance > -1e-3F) {
            continue;
        }
        ++inside;
        const float depth = -got.distance;
        EXPECT_GT(brute_distance(c.middle + got.normal * (depth + 1e-4F), c.half, c.h), 0.0);
        for (int k = 0; k < 20; ++k) {
            const Vec3 other = random_vector(rng, 1.0F).normalized();
            // Faces win over edges within a thousandth.
            EXPECT_LT(brute_distance(c.middle + other * (0.998F * depth), c.half, c.h), 1e-6);
        }
    }
    EXPECT_GT(inside, 500);
}

TEST(SegmentBoxDistance, NamesTheFacesThatTheClosestPointLiesOn) {
    const Vec3 h(1, 2, 3);
    const Vec3 up(0, 0.5F, 0);
    EXPECT_EQ(segment_box_distance(Vec3(5, 0, 0), up, h).faces, Vec3(1, 0, 0));
    EXPECT_EQ(segment_box_distance(Vec3(0, 5, 0), up, h).faces, Vec3(0, 1, 0));
    EXPECT_EQ(segment_box_distance(Vec3(-5, 9, 0), up, h).faces, Vec3(-1, 1, 0));
    EXPECT_EQ(segment_box_distance(Vec3(5, -9, 9), up, h).faces, Vec3(1, -1, 1));
    EXPECT_EQ(segment_box_distance(Vec3(0.9F, 0, 0), up, h).faces, Vec3(1, 0, 0));
    EXPECT_EQ(segment_box_distance(Vec3(-0.9F, 0, 0), up, h).faces, Vec3(-1, 0, 0));
}

TEST(SegmentBoxDistance, GivesExactNormalsForFaces) {
    const SegmentBoxDistance got =
        segment_box_distance(Vec3(0.3F, 7.25F, -0.7F), Vec3(0, 0.5F, 0), Vec3(1, 2, 3));
    EXPECT_EQ(got.normal, Vec3(0, 1, 0));
    EXPECT_EQ(got.distance, 4.75F);
}

TEST(SegmentBoxDistance, TreatsASegmentInTheCentreLikeAnyOther) {
    const SegmentBoxDistance got =
        segment_box_distance(Vec3::Zero(), Vec3(0, 0.5F, 0), Vec3(1, 2, 3));
    EXPECT_EQ(got.normal, Vec3(1, 0, 0));
    EXPECT_EQ(got.distance, -1.0F);
}

TEST(Aabb, OverlapsAndContainsItsBoundary) {
    const Aabb a{Vec3(0, 0, 0), Vec3(1, 1, 1)};
    EXPECT_TRUE(a.overlaps({Vec3(1, 1, 1), Vec3(2, 2, 2)}));
    EXPECT_FALSE(a.overlaps({Vec3(1.001F, 0, 0), Vec3(2, 2, 2)}));
    EXPECT_TRUE(a.contains(Vec3(1, 0, 1)));
    EXPECT_FALSE(a.contains(Vec3(1, 0, 1.001F)));
    EXPECT_TRUE(a.grown(0.5F).contains(Vec3(-0.5F, 1.5F, 0)));
    const float nan = std::numeric_limits<float>::quiet_NaN();
    EXPECT_FALSE(a.contains(Vec3(nan, 0, 0)));
}

}  // namespace
}  // namespace zoned
