#include "tests/scenario/ray.h"

#include "tests/scenario/penetration.h"
#include "shared/core/rng.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <limits>
#include <numbers>

namespace zoned::scenario {
namespace {

Ray along_x(double y, double length = 100.0) {
    return {Vec3d(-10.0, y, 0.0), Vec3d::UnitX(), length};
}

TEST(RayDistance, MeetsSpheresBoxesAndCapsulesHeadOn) {
    const Pose origin;
    EXPECT_NEAR(ray_distance(along_x(0.0), Solid::sphere(0.5), origin), 9.5, 1e-12);
    EXPECT_NEAR(ray_distance(along_x(0.3), Solid::sphere(0.5), origin), 9.6, 1e-12);
    EXPECT_NEAR(ray_distance(along_x(0.4), Solid::box({1, 1, 1}), origin), 9.5, 1e-12);
    EXPECT_NEAR(ray_distance(along_x(0.15), Solid::capsule(0.4, 0.2), origin), 9.6, 1e-12);
    // The round end: 0.3 above its centre.
    EXPECT_NEAR(ray_distance(along_x(0.5), Solid::capsule(0.4, 0.2), origin),
                10.0 - std::sqrt(0.16 - 0.09),
                1e-12);
}

TEST(RayDistance, IsInfiniteForMissesAndBeyondItsLength) {
    const Pose origin;
    EXPECT_FALSE(std::isfinite(ray_distance(along_x(0.6), Solid::sphere(0.5), origin)));
    EXPECT_FALSE(std::isfinite(ray_distance(along_x(0.0, 9.4), Solid::sphere(0.5), origin)));
    const Ray away{Vec3d(-10.0, 0.0, 0.0), -Vec3d::UnitX(), 100.0};
    EXPECT_FALSE(std::isfinite(ray_distance(away, Solid::box({1, 1, 1}), origin)));
}

TEST(RayDistance, IsZeroFromInside) {
    const Ray ray{Vec3d(0.1, 0.1, 0.0), Vec3d::UnitX(), 1.0};
    for (const Solid& solid :
         {Solid::sphere(0.5), Solid::box({1, 1, 1}), Solid::capsule(0.4, 0.2)}) {
        EXPECT_EQ(ray_distance(ray, solid, Pose()), 0.0);
    }
}

/// The point of the first hit touches the solid, and no point before it does: a probe of 1 um
/// radius, moved along the ray, overlaps at the hit and nowhere before.
TEST(RayDistance, EndsWhereAProbeFirstTouches) {
    core::Rng rng(3);
    const auto random = [&rng] {
        return static_cast<double>(rng.range(-1.0F, 1.0F));
    };
    const std::array<Solid, 3> solids{
        Solid::sphere(0.5), Solid::box({1.0, 0.6, 1.4}), Solid::capsule(0.4, 0.3)};
    const Solid probe = Solid::sphere(1e-6);
    int hits = 0;
    for (int trial = 0; trial < 300; ++trial) {
        const Solid& solid = solids[static_cast<std::size_t>(trial % 3)];
        const Vec3d axis = Vec3d(random(), random(), random() + 1.5).normalized();
        const Pose pose{Vec3d(random(), random(), random()),
                        Quatd(Eigen::AngleAxisd(3.0 * random(), axis))};
        const Vec3d from(4.0 * random(), 4.0, 4.0 * random());
        const Vec3d to = pose.position + 0.5 * Vec3d(random(), random(), random());
        const Ray ray{from, (to - from).normalized(), 20.0};
        const double t = ray_distance(ray, solid, pose);
        const auto touches = [&](double at) {
            const Pose there{ray.origin + at * ray.direction, Quatd::Identity()};
            return penetration(solid, pose, probe, there) > 0.0;
        };
        if (std::isfinite(t)) {
            ++hits;
            EXPECT_TRUE(touches(t)) << trial;
        }
        for (int i = 0; i < 200; ++i) {
            const double before = std::min(t, ray.length) * i / 200.0;
            // A grazing ray comes closer than the probe's radius a little before it hits.
            EXPECT_FALSE(t - before > 0.01 && touches(before)) << trial;
        }
    }
    EXPECT_GT(hits, 100);
}

}  // namespace
}  // namespace zoned::scenario
