#include "tests/bench/compare/rank_statistics.h"

#include <gmock/gmock.h>

#include <cmath>
#include <random>
#include <vector>

namespace zoned::bench {
namespace {

/// By all signs.
double p_by_enumeration(const std::vector<double>& values) {
    std::vector<double> ranks;
    for (const double a : values) {
        double rank = 0.5;
        for (const double b : values) {
            rank += std::abs(b) < std::abs(a) ? 1.0 : std::abs(b) == std::abs(a) ? 0.5 : 0.0;
        }
        ranks.push_back(rank);
    }
    double observed = 0.0;
    for (std::size_t i = 0; i < values.size(); ++i) {
        observed += values[i] > 0.0 ? ranks[i] : 0.0;
    }
    std::size_t as_large = 0;
    const std::size_t all = std::size_t{1} << values.size();
    for (std::size_t signs = 0; signs < all; ++signs) {
        double sum = 0.0;
        for (std::size_t i = 0; i < values.size(); ++i) {
            sum += (signs >> i & 1U) != 0 ? ranks[i] : 0.0;
        }
        as_large += sum >= observed - 1e-9 ? 1 : 0;
    }
    return static_cast<double>(as_large) / static_cast<double>(all);
}

TEST(SignedRank, AgreesWithAllSignsTriedOut) {
    std::mt19937 random(2);
    std::uniform_int_distribution<int> value(-6, 9);  // with ties
    for (int round = 0; round < 50; ++round) {
        std::vector<double> values;
        while (values.size() < 10) {
            const int v = value(random);
            if (v != 0) {
                values.push_back(v);
            }
        }
        EXPECT_NEAR(signed_rank_p(values, 0.0), p_by_enumeration(values), 1e-12);
    }
    EXPECT_NEAR(signed_rank_p(std::vector<double>(12, 1.0), 0.5), std::pow(0.5, 12), 1e-15);
    EXPECT_EQ(signed_rank_p(std::vector<double>{}, 0.0), 1.0);
    EXPECT_EQ(signed_rank_p(std::vector<double>{3.0, 3.0}, 3.0), 1.0);
}

// Hollander and Wolfe, example 3.1 (depression scale): the estimate is -0.46, and the interval of
// 96 % from -0.786 to -0.010.
TEST(HodgesLehmann, GivesTheFiguresOfTheBook) {
    const std::vector<double> values{
        -0.952, 0.147, -1.022, -0.430, -0.620, -0.590, -0.490, 0.080, -0.010};
    const Location at = hodges_lehmann(values);
    EXPECT_NEAR(at.middle, -0.46, 5e-4);
    EXPECT_NEAR(at.low, -0.786, 5e-4);
    EXPECT_NEAR(at.high, -0.010, 5e-4);
}

TEST(HodgesLehmann, CoversTheMiddleOfHeavyTailsAsOftenAsItSays) {
    std::mt19937 random(4);
    std::student_t_distribution<double> noise(2.0);
    int covered = 0;
    for (int round = 0; round < 1000; ++round) {
        std::vector<double> values;
        for (int i = 0; i < 12; ++i) {
            values.push_back(5.0 + noise(random));
        }
        const Location at = hodges_lehmann(values);
        covered += at.low <= 5.0 && 5.0 <= at.high ? 1 : 0;
    }
    EXPECT_GE(covered, 940);
    EXPECT_LE(covered, 980);
}

TEST(Holm, MultipliesTheLeastMost) {
    EXPECT_THAT(holm(std::vector<double>{0.01, 0.04, 0.03, 0.005}),
                testing::Pointwise(testing::DoubleEq(), {0.03, 0.06, 0.06, 0.02}));
    EXPECT_TRUE(holm(std::vector<double>{}).empty());
    EXPECT_EQ(holm(std::vector<double>{0.9, 0.8})[0], 1.0);
}

}  // namespace
}  // namespace zoned::bench
