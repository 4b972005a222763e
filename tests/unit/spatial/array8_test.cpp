#include "shared/math/array8.h"

#include "shared/core/rng.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace zoned {
namespace {

using Numbers = std::array<float, 8>;

Numbers random_numbers(core::Rng& rng) {
    Numbers out;
    for (float& number : out) {
        number = rng.range(-100.0F, 100.0F);
    }
    return out;
}

TEST(Array8, ComputesEachLaneAsIfItWereAlone) {
    core::Rng rng(3);
    for (int round = 0; round < 1000; ++round) {
        const Numbers a = random_numbers(rng);
        const Numbers b = random_numbers(rng);
        const Array8 x = Array8::load(a.data());
        const Array8 y = Array8::load(b.data());
        const Array8 product = x * y - x / y + 0.5F;
        const Array8 chosen = (x > y).select(x.square(), -y);
        const Array8 whole = Array8::from(x.truncated());
        Numbers stored;
        x.min(y).store(stored.data());
        for (std::size_t i = 0; i < 8; ++i) {
            const auto lane = static_cast<std::ptrdiff_t>(i);
            EXPECT_EQ(product[lane], a[i] * b[i] - a[i] / b[i] + 0.5F);
            EXPECT_EQ(chosen[lane], a[i] > b[i] ? a[i] * a[i] : -b[i]);
            EXPECT_EQ(whole[lane], std::trunc(a[i]));
            EXPECT_EQ(stored[i], std::min(a[i], b[i]));
            EXPECT_EQ(x.max(y)[lane], std::max(a[i], b[i]));
            EXPECT_EQ(x.abs()[lane], std::abs(a[i]));
        }
        EXPECT_EQ(x.lowest(), *std::min_element(a.begin(), a.end()));
        EXPECT_EQ(x.highest(), *std::max_element(a.begin(), a.end()));
        EXPECT_EQ(x.sum(), ((a[0] + a[4]) + (a[1] + a[5])) + ((a[2] + a[6]) + (a[3] + a[7])));
    }
}

TEST(Array8, KeepsItsOwnNumberBesideOneThatIsNone) {
    const Array8 none = std::numeric_limits<float>::quiet_NaN();
    const Array8 one = 1.0F;
    EXPECT_EQ(one.min(none)[3], 1.0F);
    EXPECT_EQ(one.max(none)[3], 1.0F);
    EXPECT_TRUE(std::isnan(none.max(one)[3]));
}

}  // namespace
}  // namespace zoned
