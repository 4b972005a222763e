#include "tests/bench/statistics.h"

#include <gtest/gtest.h>

namespace zoned::bench {
namespace {

TEST(Quantile, LiesBetweenOrderStatistics) {
    const std::vector<double> values{4.0, 1.0, 3.0, 2.0};
    EXPECT_DOUBLE_EQ(quantile(values, 0.0), 1.0);
    EXPECT_DOUBLE_EQ(quantile(values, 1.0), 4.0);
    EXPECT_DOUBLE_EQ(quantile(values, 0.5), 2.5);
    EXPECT_DOUBLE_EQ(quantile(values, 0.25), 1.75);
}

TEST(Quantile, OfNothingIsZero) {
    EXPECT_EQ(quantile({}, 0.5), 0.0);
    EXPECT_EQ(mean({}), 0.0);
    EXPECT_EQ(largest({}), 0.0);
}

TEST(Median, OfAnOddNumberIsTheMiddleOne) {
    const std::vector<double> values{9.0, 1.0, 5.0};
    EXPECT_DOUBLE_EQ(median(values), 5.0);
}

TEST(MedianOfRows, ForgetsADisturbanceInOneRow) {
    const std::vector<std::vector<double>> rows{{1.0, 2.0}, {1.0, 900.0}, {1.5, 2.5}};
    EXPECT_EQ(median_of_rows(rows), (std::vector<double>{1.0, 2.5}));
}

TEST(Largest, FindsNegativeValuesToo) {
    EXPECT_DOUBLE_EQ(largest(std::vector<double>{-3.0, -1.0}), -1.0);
}

}  // namespace
}  // namespace zoned::bench
