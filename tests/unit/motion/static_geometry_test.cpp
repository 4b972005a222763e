#include "shared/motion/static_geometry.h"

#include "shared/core/rng.h"

#include <gtest/gtest.h>

#include <cstdint>
#include <limits>
#include <vector>

namespace zoned::motion {
namespace {

std::vector<StaticBox> random_boxes(core::Rng& rng, int count, float extent) {
    std::vector<StaticBox> boxes;
    for (int i = 0; i < count; ++i) {
        StaticBox b;
        b.centre = Vec3(rng.range(-extent, extent), rng.range(0, 5), rng.range(-extent, extent));
        b.half_extents = Vec3(rng.range(0.1F, 20), rng.range(0.1F, 3), rng.range(0.1F, 20));
        b.orientation = Quat(Eigen::AngleAxisf(rng.range(0, 6), Vec3::UnitY())) *
                        Quat(Eigen::AngleAxisf(rng.range(-1, 1), Vec3::UnitX()));
        boxes.push_back(b);
    }
    return boxes;
}

TEST(StaticGeometry, VisitsExactlyTheBoxesWhoseBoundsOverlapOnceAndInOrder) {
    core::Rng rng(1);
    for (const float cell : {1.0F, 16.0F, 500.0F}) {
        for (const int count : {0, 1, 200}) {
            const StaticGeometry world(random_boxes(rng, count, 100.0F), 0.0F, cell);
            for (int i = 0; i < 500; ++i) {
                const Vec3 a(rng.range(-150, 150), rng.range(-5, 8), rng.range(-150, 150));
                const Vec3 size(rng.range(0, 20), rng.range(0, 3), rng.range(0, 20));
                const Aabb area{a, a + size};
                std::vector<std::uint32_t> expected;
                for (std::uint32_t b = 0; b < world.boxes().size(); ++b) {
                    if (world.box_bounds(b).overlaps(area)) {
                        expected.push_back(b);
                    }
                }
                std::vector<std::uint32_t> got;
                world.for_each_near(area, [&](std::uint32_t b) { got.push_back(b); });
                ASSERT_EQ(got, expected);
            }
        }
    }
}

TEST(StaticGeometry, AroundAPlaceHasTheBoxesThatAreThere) {
    core::Rng rng(2);
    const StaticGeometry world(random_boxes(rng, 200, 100.0F), -0.5F);
    for (int i = 0; i < 100; ++i) {
        const Vec3 a(rng.range(-60, 60), -10.0F, rng.range(-60, 60));
        const Aabb area{a, a + Vec3(rng.range(0, 40), 20.0F, rng.range(0, 40))};
        const StaticGeometry part = world.around(area);
        EXPECT_EQ(part.ground_height(), world.ground_height());
        std::vector<Vec3> expected;
        world.for_each_near(area,
                            [&](std::uint32_t b) { expected.push_back(world.box(b).centre); });
        std::vector<Vec3> got;
        part.for_each_near(area, [&](std::uint32_t b) {
            got.push_back(part.box(b).centre);
            EXPECT_TRUE(part.box_bounds(b).overlaps(area));
        });
        ASSERT_EQ(got, expected);
        EXPECT_EQ(part.boxes().size(), expected.size());
    }
}

TEST(StaticGeometry, BoundsHoldEveryCorner) {
    core::Rng rng(2);
    const StaticGeometry world(random_boxes(rng, 100, 10.0F), 0.0F);
    for (std::uint32_t b = 0; b < world.boxes().size(); ++b) {
        const StaticBox& box = world.boxes()[b];
        for (int corner = 0; corner < 8; ++corner) {
            const Vec3 sign(
                (corner & 1) != 0 ? 1 : -1, (corner & 2) != 0 ? 1 : -1, (corner & 4) != 0 ? 1 : -1);
            const Vec3 p = box.centre + box.orientation * box.half_extents.cwiseProduct(sign);
            EXPECT_TRUE(world.box_bounds(b).grown(1e-4F).contains(p));
        }
    }
}

TEST(StaticGeometry, SurvivesAreasFarOutsideAndNowhere) {
    core::Rng rng(3);
    const StaticGeometry world(random_boxes(rng, 50, 100.0F), 0.0F);
    const float nan = std::numeric_limits<float>::quiet_NaN();
    int visits = 0;
    for (const float x : {1e12F, -1e12F, 3e38F, -3e38F, nan}) {
        world.for_each_near({Vec3(x, 0, x), Vec3(x, 1, x)}, [&](std::uint32_t) { ++visits; });
    }
    EXPECT_EQ(visits, 0);
    world.for_each_near({Vec3(-3e38F, -3e38F, -3e38F), Vec3(3e38F, 3e38F, 3e38F)},
                        [&](std::uint32_t) { ++visits; });
    EXPECT_EQ(visits, 50);
}

}  // namespace
}  // namespace zoned::motion
