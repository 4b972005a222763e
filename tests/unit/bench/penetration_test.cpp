// build: computes
#include "tests/scenario/penetration.h"

#include "tests/scenario/overlaps.h"
#include "shared/core/rng.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>

namespace zoned::scenario {
namespace {

Pose at(double x, double y, double z) {
    return {Vec3d(x, y, z), Quatd::Identity()};
}

const Solid kBall = Solid::sphere(0.5);
const Solid kCube = Solid::box(Vec3d::Ones());
const Solid kPill = Solid::capsule(0.4, 0.2);

TEST(Penetration, OfSpheresIsRadiiLessDistance) {
    EXPECT_NEAR(penetration(kBall, at(0, 0, 0), kBall, at(0.6, 0, 0.0)), 0.4, 1e-12);
    EXPECT_EQ(penetration(kBall, at(0, 0, 0), kBall, at(1.1, 0, 0)), 0.0);
}

TEST(Penetration, OfCubesFaceToFaceIsTheOverlap) {
    EXPECT_NEAR(penetration(kCube, at(0, 0, 0), kCube, at(0.1, 0.9, 0.2)), 0.1, 1e-12);
    EXPECT_EQ(penetration(kCube, at(0, 0, 0), kCube, at(0, 1.0001, 0)), 0.0);
}

/// Two cubes turned by 45 degrees about crossing axes meet edge to edge: each edge is half a
/// diagonal, sqrt(2)/2, from its centre.
TEST(Penetration, OfCubesEdgeToEdgeNeedsTheCrossProducts) {
    const double eighth = std::numbers::pi / 4.0;
    const Pose a{Vec3d::Zero(), Quatd(Eigen::AngleAxisd(eighth, Vec3d::UnitX()))};
    const Pose b{Vec3d(0.0, 1.5, 0.0), Quatd(Eigen::AngleAxisd(eighth, Vec3d::UnitZ()))};
    EXPECT_EQ(penetration(kCube, a, kCube, b), 0.0);
    const Pose near{Vec3d(0.0, 1.4, 0.0), b.orientation};
    EXPECT_NEAR(penetration(kCube, a, kCube, near), std::sqrt(2.0) - 1.4, 1e-12);
}

TEST(Penetration, OfASphereInABoxLeadsOutOfTheNearestFace) {
    EXPECT_NEAR(penetration(kCube, at(0, 0, 0), kBall, at(0.3, 0.0, 0.0)), 0.7, 1e-9);
    EXPECT_NEAR(penetration(kBall, at(0.9, 0.0, 0.0), kCube, at(0, 0, 0)), 0.1, 1e-12);
    // Near a corner: the distance to the corner counts.
    const double gap = std::sqrt(3.0) * 0.2;
    EXPECT_NEAR(penetration(kCube, at(0, 0, 0), kBall, at(0.7, 0.7, 0.7)), 0.5 - gap, 1e-12);
}

TEST(Penetration, OfCapsulesFollowsTheirSegments) {
    EXPECT_NEAR(penetration(kPill, at(0, 0, 0), kPill, at(0.7, 0.1, 0)), 0.1, 1e-12);
    EXPECT_NEAR(penetration(kPill, at(0, 0, 0), kPill, at(0, 1.1, 0)), 0.1, 1e-12);
    const Pose lying{Vec3d(0.0, 0.9, 0.0),
                     Quatd(Eigen::AngleAxisd(std::numbers::pi / 2.0, Vec3d::UnitX()))};
    EXPECT_NEAR(penetration(kPill, at(0, 0, 0), kPill, lying), 0.1, 1e-12);
    EXPECT_NEAR(penetration(kCube, at(0, 0, 0), kPill, at(0, 1.0, 0)), 0.1, 1e-9);
}

/// Half-extent of a solid along a direction, from its definition.
double support(const Solid& solid, const Pose& pose, const Vec3d& n) {
    const Vec3d local = pose.orientation.conjugate() * n;
    if (solid.form == Form::kBox) {
        return local.cwiseAbs().dot(solid.half_extents);
    }
    const double half = solid.form == Form::kCapsule ? solid.half_segment : 0.0;
    return solid.radius + std::abs(local.y()) * half;
}

/// The depth is the least overlap over all directions (support functions of convex solids): no
/// sampled direction may give less, and near the best one the sampling comes close.
TEST(Penetration, IsTheLeastOverlapOverAllDirections) {
    core::Rng rng(11);
    const auto unit = [&rng] {
        Vec3d v;
        do {
            v = Vec3d(rng.range(-1, 1), rng.range(-1, 1), rng.range(-1, 1));
        } while (v.norm() > 1.0 || v.norm() < 1e-3);
        return Vec3d(v.normalized());
    };
    const std::array<Solid, 3> solids{kBall, Solid::box({1.0, 0.6, 1.4}), kPill};
    int overlapping = 0;
    for (int trial = 0; trial < 60; ++trial) {
        const Solid& a = solids[static_cast<std::size_t>(trial % 3)];
        const Solid& b = solids[static_cast<std::size_t>(trial / 3 % 3)];
        const Pose at_a{Vec3d::Zero(), Quatd(Eigen::AngleAxisd(rng.range(0, 3), unit()))};
        const Pose at_b{unit() * static_cast<double>(rng.range(0.5F, 1.1F)),
                        Quatd(Eigen::AngleAxisd(rng.range(0, 3), unit()))};
        const double depth = penetration(a, at_a, b, at_b);
        double least = std::numeric_limits<double>::max();
        for (int i = 0; i < 40'000; ++i) {
            const Vec3d n = unit();
            const double reach = support(a, at_a, n) + support(b, at_b, n);
            least = std::min(least, reach - std::abs(n.dot(at_b.position)));
        }
        EXPECT_LE(depth, std::max(least, 0.0) + 1e-9) << trial;
        // 40,000 directions leave gaps of about 0.02 rad; at a face the overlap grows by the
        // half-diagonals' sum, at most 2 m, times the angle.
        EXPECT_GE(depth, std::max(least, 0.0) - 0.04) << trial;
        overlapping += depth > 0.0 ? 1 : 0;
    }
    EXPECT_GT(overlapping, 20);
}

TEST(DepthBelowGround, IsOfTheLowestPoint) {
    EXPECT_NEAR(depth_below_ground(kBall, at(0, 0.4, 0)), 0.1, 1e-12);
    EXPECT_NEAR(depth_below_ground(kPill, at(0, 0.5, 0)), 0.1, 1e-12);
    const Pose tilted{Vec3d(0.0, 0.7, 0.0),
                      Quatd(Eigen::AngleAxisd(std::numbers::pi / 4.0, Vec3d::UnitX()))};
    EXPECT_NEAR(depth_below_ground(kCube, tilted), std::sqrt(0.5) - 0.7, 1e-12);
    EXPECT_EQ(depth_below_ground(kCube, at(0, 0.5, 0)), 0.0);
}

TEST(FindOverlaps, FindsWhatAllPairsFind) {
    Description pile_scene = pile(5);
    core::Rng rng(7);
    std::vector<Pose> poses;
    for (const Body& body : pile_scene.bodies) {
        Pose pose = body.pose;
        if (body.mass > 0.0) {
            pose.position *= 0.6;  // pressed into each other
            pose.orientation = Quatd(Eigen::AngleAxisd(rng.range(0, 3), Vec3d::UnitX()));
        }
        poses.push_back(pose);
    }
    const Overlaps found = find_overlaps(pile_scene.bodies, poses);
    std::vector<double> brute;
    for (std::size_t i = 0; i < poses.size(); ++i) {
        for (std::size_t j = i + 1; j < poses.size(); ++j) {
            const Body& a = pile_scene.bodies[i];
            const Body& b = pile_scene.bodies[j];
            if (a.mass > 0.0 && b.mass > 0.0) {
                const double depth = penetration(a.solid, poses[i], b.solid, poses[j]);
                if (depth > 0.0) {
                    brute.push_back(depth);
                }
            }
        }
    }
    std::vector<double> pairs = found.pairs;
    std::sort(pairs.begin(), pairs.end());
    std::sort(brute.begin(), brute.end());
    ASSERT_EQ(pairs.size(), brute.size());
    ASSERT_GT(brute.size(), 100u);
    for (std::size_t i = 0; i < brute.size(); ++i) {
        EXPECT_NEAR(pairs[i], brute[i], 1e-9);
    }
}

}  // namespace
}  // namespace zoned::scenario
