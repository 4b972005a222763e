// Histogram: percentiles of any number of samples in bounded memory.
#include "shared/core/histogram.h"

#include "shared/core/rng.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

namespace zoned::core {
namespace {

TEST(Histogram, GivesPercentilesWithinHalfABucket) {
    core::Rng rng(1);
    std::vector<double> all;
    Histogram h;
    for (int i = 0; i < 20000; ++i) {
        const double v = std::exp(static_cast<double>(rng.range(-8.0F, 8.0F)));
        all.push_back(v);
        h.add(v);
    }
    std::sort(all.begin(), all.end());
    for (const double p : {0.01, 0.5, 0.9, 0.99, 0.999}) {
        const double exact = all[static_cast<std::size_t>(std::ceil(p * 20000.0)) - 1];
        // Buckets are 1/32 of a power of two wide, so at most 1/32 of a value; half of it.
        EXPECT_NEAR(h.percentile(p), exact, exact / 64.0 * 1.0001);
    }
    EXPECT_EQ(h.max(), all.back());
    EXPECT_EQ(Histogram().percentile(0.5), 0.0);
}

TEST(Histogram, CountsWhatIsNotANumberAsHuge) {
    Histogram h;
    h.add(std::numeric_limits<double>::quiet_NaN());
    EXPECT_GT(h.max(), 1e6);
}

}  // namespace
}  // namespace zoned::core
