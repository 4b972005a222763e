// Morton codes: bits of three coordinates in turn, and points outside the range.
#include "server/spatial/morton.h"

#include <gtest/gtest.h>

#include <limits>

namespace zoned::spatial {
namespace {

const Aabb kBox{Vec3(-512, -512, -512), Vec3(512, 512, 512)};

TEST(Morton, InterlacesTheBitsOfTheCells) {
    EXPECT_EQ(morton_code(Vec3(-511.5F, -511.5F, -511.5F), kBox), 0U);
    EXPECT_EQ(morton_code(Vec3(-510.5F, -511.5F, -511.5F), kBox), 1U);
    EXPECT_EQ(morton_code(Vec3(-511.5F, -510.5F, -511.5F), kBox), 2U);
    EXPECT_EQ(morton_code(Vec3(-511.5F, -511.5F, -510.5F), kBox), 4U);
    EXPECT_EQ(morton_code(Vec3(-509.5F, -511.5F, -511.5F), kBox), 8U);
    EXPECT_EQ(morton_code(Vec3(511.5F, 511.5F, 511.5F), kBox), (1U << 30) - 1U);
    for (std::uint32_t x = 0; x < 1024; ++x) {
        std::uint32_t expected = 0;
        for (int bit = 0; bit < 10; ++bit) {
            expected |= ((x >> bit) & 1U) << (3 * bit);
        }
        ASSERT_EQ(spread_bits(x), expected);
    }
}

TEST(Morton, TakesPointsOutsideToTheBorder) {
    constexpr float kInf = std::numeric_limits<float>::infinity();
    EXPECT_EQ(morton_code(Vec3(kInf, kInf, kInf), kBox), (1U << 30) - 1U);
    EXPECT_EQ(morton_code(Vec3(-kInf, -1.0e6F, -kInf), kBox), 0U);
    const float nan = std::numeric_limits<float>::quiet_NaN();
    EXPECT_EQ(morton_code(Vec3(nan, nan, nan), kBox), 0U);
    EXPECT_EQ(morton_code(Vec3(1, 2, 3), Aabb{Vec3(1, 2, 3), Vec3(1, 2, 3)}), 0U);
}

}  // namespace
}  // namespace zoned::spatial
