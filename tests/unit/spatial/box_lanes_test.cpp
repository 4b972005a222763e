#include "server/spatial/box_lanes.h"

#include "shared/core/rng.h"

#include <gtest/gtest.h>

#include <array>
#include <limits>

namespace zoned::spatial {
namespace {

TEST(BoxLanes, AgreeWithOneBoxAtATime) {
    core::Rng rng(1);
    for (int round = 0; round < 500; ++round) {
        // Coordinates on a coarse lattice, so that boxes often just touch.
        const auto lattice = [&] {
            return 0.25F * static_cast<float>(rng.below(40));
        };
        const auto box = [&] {
            const Vec3 a(lattice(), lattice(), lattice());
            return Aabb{a, a + Vec3(lattice(), lattice(), lattice())};
        };
        BoxLanes lanes;
        std::array<Aabb, kLanes> boxes;
        for (std::size_t i = 0; i < kLanes; ++i) {
            boxes[i] = box();
            lanes.set(i, boxes[i]);
            EXPECT_EQ(lanes.get(i).lower, boxes[i].lower);
            EXPECT_EQ(lanes.get(i).upper, boxes[i].upper);
        }
        const Aabb query = box();
        const Vec3 direction =
            round % 4 == 0
                ? Vec3(Vec3::Unit(round % 3))
                : Vec3(Vec3(rng.range(-1, 1), rng.range(-1, 1), rng.range(-1, 1)).normalized());
        const SweepLanes sweep({query.lower, direction, 0.5F * Vec3(lattice(), 0, lattice())});
        const float limit = rng.range(0, 20);
        const std::uint32_t overlapping = lanes.overlapping(query);
        Array8 enter;
        const std::uint32_t met = lanes.met_by(sweep, limit, enter);
        const Array8 squared = lanes.squared_distance(query.lower);
        for (std::size_t i = 0; i < kLanes; ++i) {
            EXPECT_EQ((overlapping >> i & 1U) != 0, boxes[i].overlaps(query));
            EXPECT_EQ((met >> i & 1U) != 0, sweep.meets(boxes[i], limit));
            EXPECT_EQ(squared[static_cast<int>(i)], squared_distance(boxes[i], query.lower));
        }
        lanes.clear(3);
        EXPECT_EQ(lanes.overlapping(query) & 8U, 0U);
        EXPECT_EQ(lanes.met_by(sweep, INFINITY, enter) & 8U, 0U);
    }
}

TEST(BoxLanes, ALaneThatIsNoNumberIsNeverAtMostAnything) {
    Array8 a = 0.0F;
    a[2] = std::numeric_limits<float>::quiet_NaN();
    a[5] = 1.0F;
    EXPECT_EQ(lanes_at_most(a, 0.0F), 0xFFU & ~(1U << 2) & ~(1U << 5));
}

}  // namespace
}  // namespace zoned::spatial
