// build: computes
#include "server/physics/query/shape_ray.h"

#include "tests/unit/physics/hulls.h"

#include <gtest/gtest.h>

namespace zoned::physics {
namespace {

TEST(CastRay, HitsTheHullOfABoxWhereItHitsTheBox) {
    core::Rng rng(51);
    const Vec3 half(0.5F, 0.8F, 0.3F);
    const Shape box = Shape::box(half);
    const Shape hull = hull_shape(box_corners(half));
    int hits = 0;
    for (int round = 0; round < 5000; ++round) {
        const Mat3 rotation = random_rotation(rng).toRotationMatrix();
        const Vec3 position = random_points(rng, 1, 1.0F)[0];
        const Vec3 origin = random_points(rng, 1, 2.0F)[0];
        const Vec3 direction = (random_points(rng, 1, 1.0F)[0] - origin).normalized();
        float t_box = 0.0F;
        float t_hull = 0.0F;
        Vec3 n_box;
        Vec3 n_hull;
        const bool on_box =
            cast_ray({box, position, rotation}, origin, direction, 10.0F, t_box, n_box);
        const bool on_hull =
            cast_ray({hull, position, rotation}, origin, direction, 10.0F, t_hull, n_hull);
        ASSERT_EQ(on_box, on_hull) << round;
        if (on_box) {
            ++hits;
            ASSERT_NEAR(t_box, t_hull, 2e-5F) << round;
            ASSERT_GT(n_box.dot(n_hull), 0.9999F) << round;
        }
    }
    EXPECT_GT(hits, 1000);
}

}  // namespace
}  // namespace zoned::physics
