// Statics and terrain: hills that can be walked, walls with openings, heights from above.
#include "server/config/world/statics.h"

#include "server/config/world/terrain.h"
#include "tests/unit/config/config_helpers.h"
#include "shared/core/rng.h"

#include <cmath>

namespace zoned::config::test {
namespace {

std::vector<motion::StaticBox> expand(const std::string& statics) {
    const Outcome out = parse(kValid + "statics { " + statics + " }\n");
    EXPECT_TRUE(out.ok) << format_errors("test", out.errors);
    return out.settings.boxes;
}

TEST(Hill, RisesFromTheGroundToItsTopOverRampsWithoutASteepStep) {
    for (const double yaw : {0.0, 30.0, 200.0}) {
        SCOPED_TRACE(yaw);
        const Terrain terrain(
            expand("hill { x_m: 40 z_m: 0 top_size_m: 10 terraces: 3 terrace_height_m: 1.5 "
                   "terrace_depth_m: 5 ramp_slope_deg: 25 yaw_deg: " +
                   std::to_string(yaw) + " }"),
            0.0F);
        EXPECT_NEAR(terrain.height(40.0F, 0.0F), 4.5F, 1e-4F);
        // From the top outwards through the middle of each ramp: no step is steeper than the ramp.
        const float slope = std::tan(25.0F * 3.14159265F / 180.0F);
        for (int side = 0; side < 4; ++side) {
            const double angle = (yaw + 90.0 * side) * 3.14159265358979 / 180.0;
            const auto dx = static_cast<float>(std::cos(angle));
            const auto dz = static_cast<float>(-std::sin(angle));
            float before = 4.5F;
            for (float r = 0.0F; r < 30.0F; r += 0.05F) {
                const float h = terrain.height(40.0F + r * dx, r * dz);
                // A millimetre for rounding of the rotated boxes.
                EXPECT_LE(std::abs(h - before), 0.05F * slope + 1e-3F)
                    << "side " << side << " r " << r;
                before = h;
            }
            EXPECT_EQ(before, 0.0F);
        }
    }
}

TEST(Hill, HasRampsOnlyOnTheSidesThatAreAskedFor) {
    EXPECT_EQ(expand("hill { x_m: 0 z_m: 0 terraces: 2 ramp_sides: 1 top_size_m: 8 }").size(), 4u);
    EXPECT_EQ(expand("hill { x_m: 0 z_m: 20 terraces: 2 ramp_sides: 4 top_size_m: 8 } ").size(),
              10u);
}

TEST(Wall, IsCutIntoSegmentsWithOpenings) {
    // 40 m with pieces of at most 9 m and gaps of 1 m: (40 + 1) / (9 + 1) -> 5 pieces of 7.2 m.
    const auto boxes = expand(
        "wall { point { x_m: -20 z_m: 10 } point { x_m: 20 z_m: 10 } segment_m: 9 gap_m: 1 }");
    ASSERT_EQ(boxes.size(), 5u);
    float total = 0.0F;
    for (const motion::StaticBox& box : boxes) {
        total += 2.0F * box.half_extents.x();
        EXPECT_NEAR(box.centre.z(), 10.0F, 1e-5F);
        EXPECT_NEAR(box.centre.y(), 1.5F, 1e-5F);
    }
    EXPECT_NEAR(total, 36.0F, 1e-3F);
    EXPECT_NEAR(boxes.front().centre.x() - boxes.front().half_extents.x(), -20.0F, 1e-4F);
    EXPECT_NEAR(boxes.back().centre.x() + boxes.back().half_extents.x(), 20.0F, 1e-4F);
    const Terrain terrain(boxes, 0.0F);
    EXPECT_EQ(terrain.height(-20.0F + 7.7F, 10.0F), 0.0F) << "the first opening";
    EXPECT_NEAR(terrain.height(-20.0F + 7.0F, 10.0F), 3.0F, 1e-4F);
}

TEST(Wall, FollowsItsPointsInAnyDirection) {
    const Terrain terrain(
        expand("wall { point { x_m: 10 z_m: 10 } point { x_m: 20 z_m: 30 } height_m: 2 }"), 0.0F);
    EXPECT_NEAR(terrain.height(14.0F, 18.0F), 2.0F, 1e-4F);
    EXPECT_NEAR(terrain.height(11.0F, 12.0F), 2.0F, 1e-4F);
    EXPECT_EQ(terrain.height(19.0F, 12.0F), 0.0F);
}

TEST(Box, TurnsByYawThenPitchThenRoll) {
    const auto boxes = expand("box { yaw_deg: 90 pitch_deg: 30 y_m: 5 }");
    ASSERT_EQ(boxes.size(), 1u);
    // Pitch about x takes z to (0, -sin 30, cos 30); yaw of 90 degrees about y takes z to x.
    const Vec3 z = boxes[0].orientation * Vec3::UnitZ();
    EXPECT_NEAR(z.x(), std::cos(0.5235988F), 1e-6F);
    EXPECT_NEAR(z.y(), -0.5F, 1e-6F);
    EXPECT_NEAR(z.z(), 0.0F, 1e-6F);
}

TEST(Terrain, FindsTheHighestOfStackedBoxes) {
    const Terrain terrain(expand("box { x_m: 30 y_m: 1 size { x_m: 4 y_m: 2 z_m: 4 } }"
                                 "box { x_m: 30 y_m: 2.5 size { x_m: 1 y_m: 1 z_m: 1 } }"),
                          0.0F);
    EXPECT_NEAR(terrain.height(30.0F, 0.0F), 3.0F, 1e-5F);
    EXPECT_NEAR(terrain.height(31.5F, 0.0F), 2.0F, 1e-5F);
    EXPECT_EQ(terrain.height(32.5F, 0.0F), 0.0F);
    EXPECT_TRUE(terrain.level(10.0F, 0.0F, 1.0F));
    EXPECT_FALSE(terrain.level(32.5F, 0.0F, 1.0F));
}

TEST(BoxesOverlap, AgreesWithSamplingOfRandomBoxes) {
    core::Rng rng(5);
    int overlaps = 0;
    for (int trial = 0; trial < 2000; ++trial) {
        motion::StaticBox box;
        box.centre = Vec3(rng.range(-2, 2), rng.range(-2, 2), rng.range(-2, 2));
        box.half_extents = Vec3(rng.range(0.1F, 1), rng.range(0.1F, 1), rng.range(0.1F, 1));
        box.orientation =
            Quat(rng.range(-1, 1), rng.range(-1, 1), rng.range(-1, 1), rng.range(-1, 1))
                .normalized();
        const Aabb area{Vec3(-0.7F, -0.4F, -0.9F), Vec3(0.7F, 0.4F, 0.9F)};
        bool sampled = false;
        for (int s = 0; s < 400 && !sampled; ++s) {
            const Vec3 local(rng.range(-1, 1), rng.range(-1, 1), rng.range(-1, 1));
            sampled = area.contains(box.centre +
                                    box.orientation * Vec3(local.cwiseProduct(box.half_extents)));
        }
        const bool found = boxes_overlap(area, box);
        overlaps += found ? 1 : 0;
        // A sample inside both proves overlap; no sample proves nothing, so only this direction.
        EXPECT_TRUE(found || !sampled);
        // Spheres around both that are apart prove the opposite.
        const float reach = 0.5F * (area.upper - area.lower).norm() + box.half_extents.norm();
        EXPECT_TRUE(!found || box.centre.norm() < reach);
    }
    EXPECT_GT(overlaps, 300);
    EXPECT_LT(overlaps, 1700);
}

}  // namespace
}  // namespace zoned::config::test
