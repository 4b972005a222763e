#include "shared/math/heading.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <numbers>

namespace zoned {
namespace {

TEST(Heading, IsThatOfItsYawAllAround) {
    for (int yaw = 0; yaw < 65536; ++yaw) {
        const Vec2 heading = heading_of(static_cast<std::uint16_t>(yaw));
        const double angle = yaw * std::numbers::pi / 32768.0;
        // Rounded to floats once: half a unit in the last place of numbers up to 1.
        EXPECT_NEAR(heading.x(), std::sin(angle), 0x1p-24);
        EXPECT_NEAR(heading.y(), std::cos(angle), 0x1p-24);
        // An arc tangent in floats is within two units of 2^-24 of a turn's 65536th part.
        const int off = static_cast<std::int16_t>(yaw_of(heading) - yaw);
        EXPECT_LE(std::abs(off), 1);
    }
}

}  // namespace
}  // namespace zoned
