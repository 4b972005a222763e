// build: computes
#include "tests/scenario/penetration.h"
#include "tests/scenario/solid_geometry.h"
#include "shared/core/rng.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace zoned::scenario {
namespace {

std::vector<Vec3d> corners_of_box(const Vec3d& half) {
    std::vector<Vec3d> points;
    for (int i = 0; i < 8; ++i) {
        points.push_back(
            Vec3d((i & 1) != 0 ? 1.0 : -1.0, (i & 2) != 0 ? 1.0 : -1.0, (i & 4) != 0 ? 1.0 : -1.0)
                .cwiseProduct(half));
    }
    return points;
}

Quatd any_turn(core::Rng& rng) {
    const auto x = [&rng] {
        return static_cast<double>(rng.range(-1.0F, 1.0F));
    };
    const double w = x();
    const double a = x();
    const double b = x();
    return Quatd(w, a, b, x()).normalized();
}

TEST(SolidHull, OfABoxIsTheBox) {
    const Vec3d half(0.3, 0.5, 0.8);
    const BuiltSolid built = solid_hull(corners_of_box(half));
    const Solid box = Solid::box(2.0 * half);
    EXPECT_NEAR(built.solid.volume(), box.volume(), 1e-12);
    EXPECT_EQ(built.solid.geometry->faces.size(), 6u);
    EXPECT_EQ(built.solid.geometry->edges.size(), 12u);
    Vec3d moments = built.solid.inertia_per_mass();
    Vec3d expected = box.inertia_per_mass();
    std::sort(moments.data(), moments.data() + 3);
    std::sort(expected.data(), expected.data() + 3);
    EXPECT_LT((moments - expected).norm(), 1e-12);
}

/// Two halves of a box, one of them turned in its own axes, are the box.
TEST(SolidCompound, OfTwoHalvesIsTheWhole) {
    const Quatd turn(Eigen::AngleAxisd(0.5 * M_PI, Vec3d::UnitX()));
    const SolidPart left{Solid::box({1.0, 2.0, 3.0}), {Vec3d(-0.5, 0.0, 0.0), Quatd::Identity()}};
    const SolidPart right{Solid::box({1.0, 3.0, 2.0}), {Vec3d(0.5, 0.0, 0.0), turn}};
    const BuiltSolid built = solid_compound(std::vector<SolidPart>{left, right});
    Vec3d moments = built.solid.inertia_per_mass();
    Vec3d expected = Solid::box({2.0, 2.0, 3.0}).inertia_per_mass();
    std::sort(moments.data(), moments.data() + 3);
    std::sort(expected.data(), expected.data() + 3);
    EXPECT_NEAR(built.solid.volume(), 12.0, 1e-12);
    EXPECT_LT((moments - expected).norm(), 1e-12);
    EXPECT_LT(built.pose.position.norm(), 1e-12);
}

/// The overlap of two boxes, found for boxes and for the hulls of their corners.
TEST(Penetration, OfHullsIsThatOfTheBoxesThatTheyAre) {
    core::Rng rng(1);
    int overlapping = 0;
    for (int i = 0; i < 300; ++i) {
        const Vec3d a(0.5, 0.7, 0.4);
        const Vec3d b(0.3, 0.6, 0.9);
        Pose at_b;
        at_b.orientation = any_turn(rng);
        at_b.position = any_turn(rng) * Vec3d(0.9, 0.0, 0.0);
        const BuiltSolid hull_a = solid_hull(corners_of_box(a));
        const BuiltSolid hull_b = solid_hull(corners_of_box(b));
        const Pose hull_at_b{at_b.position + at_b.orientation * hull_b.pose.position,
                             at_b.orientation * hull_b.pose.orientation};
        const double boxes = penetration(Solid::box(2.0 * a), {}, Solid::box(2.0 * b), at_b);
        EXPECT_NEAR(penetration(hull_a.solid, hull_a.pose, hull_b.solid, hull_at_b), boxes, 1e-9);
        overlapping += boxes > 0.0 ? 1 : 0;
    }
    EXPECT_GT(overlapping, 50);
}

/// Where the core of a capsule stays outside, its distance decides for boxes and hulls alike.
TEST(Penetration, OfAHullAndACapsuleIsThatOfTheBoxThatItIs) {
    core::Rng rng(2);
    const Vec3d half(0.5, 0.7, 0.4);
    const BuiltSolid hull = solid_hull(corners_of_box(half));
    const Solid capsule = Solid::capsule(0.3, 0.4);
    int overlapping = 0;
    for (int i = 0; i < 300; ++i) {
        Pose pose;
        pose.orientation = any_turn(rng);
        pose.position = any_turn(rng) * Vec3d(1.1, 0.0, 0.0);
        const double box = penetration(Solid::box(2.0 * half), {}, capsule, pose);
        if (box < capsule.radius) {
            EXPECT_NEAR(penetration(hull.solid, hull.pose, capsule, pose), box, 1e-6);
            overlapping += box > 0.0 ? 1 : 0;
        }
    }
    EXPECT_GT(overlapping, 50);
}

TEST(Penetration, OfAMeshIsTheDepthBehindItsTriangles) {
    const Solid slope =
        solid_terrain(10, 10, 1.0, -5.0, -5.0, [](double x, double) { return 0.75 * x; });
    // The normal of the slope is (-3, 4, 0) / 5.
    const Vec3d normal(-0.6, 0.8, 0.0);
    const Vec3d along(0.8, 0.6, 0.0);
    Pose pose;
    pose.position = 0.4 * normal + 0.7 * along + Vec3d(0.0, 0.0, 0.3);
    EXPECT_NEAR(penetration(slope, {}, Solid::sphere(0.5), pose), 0.1, 1e-12);
    pose.orientation = Quatd::FromTwoVectors(Vec3d::UnitY(), normal);
    EXPECT_NEAR(penetration(Solid::box({1.0, 1.0, 1.0}), pose, slope, {}), 0.1, 1e-12);
    const BuiltSolid hull = solid_hull(corners_of_box(Vec3d::Constant(0.5)));
    const Pose at_hull{pose.position, pose.orientation * hull.pose.orientation};
    EXPECT_NEAR(penetration(slope, {}, hull.solid, at_hull), 0.1, 1e-9);
    pose.position += 0.2 * normal;
    EXPECT_EQ(penetration(slope, {}, Solid::sphere(0.5), pose), 0.0);
}

}  // namespace
}  // namespace zoned::scenario
