#include "tests/bench/compare/baseline.h"

#include "tests/bench/compare/calibration.h"
#include "tests/bench/report/results_reader.h"

#include <gmock/gmock.h>

#include <cmath>
#include <random>

namespace zoned::bench {
namespace {

/// Two scenes: one beside a peer, one beside the calibration kernel.
Results pass_with(double slowness, double scene_a, double scene_b, double error) {
    Results results;
    Row row;
    row.suite = "s";
    row.scene = "a";
    row.time_us_p50 = 10.0 * slowness * scene_a;
    row.error = -error;
    results.rows.push_back(row);
    row.peer = "bullet";
    row.time_us_p50 = 40.0 * slowness;
    results.rows.push_back(row);
    row.peer.clear();
    row.scene = "b";
    row.time_us_p50 = 7.0 * slowness * scene_b;
    results.rows.push_back(row);
    results.runs = {{"s", "a", 1.0, 2, 100.0 * slowness}, {"s", "b", 1.0, 1, 100.0 * slowness}};
    return results;
}

std::vector<Results> noisy_passes(int count, double noise, double scene_b, double error) {
    std::mt19937 random(6);
    std::normal_distribution<double> normal(0.0, noise);
    std::vector<Results> passes;
    for (int i = 0; i < count; ++i) {
        passes.push_back(pass_with(
            1.0 + i, std::exp(normal(random)), scene_b * std::exp(normal(random)), error));
    }
    return passes;
}

Results stored(const std::vector<Results>& passes) {
    return results_from_json(to_json(baseline_of(passes)), "baseline");
}

TEST(Baseline, TakesDefaultsOverAPeerOrTheCalibrationKernel) {
    const Results pass = pass_with(3.0, 1.0, 1.0, 0.1);
    const std::vector<DefaultRatio> ratios = default_ratios(pass);
    ASSERT_EQ(ratios.size(), 2U);
    EXPECT_NEAR(ratios[0].ratio, 0.25, 1e-12);
    EXPECT_TRUE(ratios[0].by_peer);
    EXPECT_NEAR(ratios[1].ratio, 0.07, 1e-12);
    EXPECT_FALSE(ratios[1].by_peer);
}

TEST(Baseline, NamesWhatIsATenthSlowerAndNoSlowerMachine) {
    const Results baseline = stored(noisy_passes(5, 0.01, 1.0, 0.1));
    ASSERT_EQ(baseline.rows.size(), 2U);
    const Results same = pass_with(9.0, 1.0, 1.0, 0.1);
    EXPECT_TRUE(regressions(baseline, {&same, 1}, Limits()).empty());
    const Results slower = pass_with(9.0, 1.0, 1.15, 0.1);
    const std::vector<Finding> findings = regressions(baseline, {&slower, 1}, Limits());
    ASSERT_EQ(findings.size(), 1U);
    EXPECT_EQ(findings[0].name, "s b");
    EXPECT_EQ(findings[0].change, Change::kSlower);
    EXPECT_NEAR(findings[0].ratio, 1.15, 0.02);
    EXPECT_EQ(rows_in_common(baseline, slower), 2U);
}

// A row that scatters by a fifth is no tenth slower when it is by chance.
TEST(Baseline, GuardsAgainstTheNoiseOfItsRows) {
    const Results baseline = stored(noisy_passes(9, 0.2, 1.0, 0.1));
    const Results slower = pass_with(1.0, 1.0, 1.25, 0.1);
    EXPECT_TRUE(regressions(baseline, {&slower, 1}, Limits()).empty());
}

TEST(Baseline, TakesTheMedianOverPasses) {
    const Results baseline = stored(noisy_passes(5, 0.01, 1.0, 0.1));
    std::vector<Results> passes(5, pass_with(1.0, 1.0, 1.0, 0.1));
    passes[0] = passes[1] = pass_with(1.0, 2.0, 2.0, 0.1);  // disturbed
    EXPECT_TRUE(regressions(baseline, passes, Limits()).empty());
    passes[2] = passes[1];
    EXPECT_EQ(regressions(baseline, passes, Limits()).size(), 2U);
}

TEST(Baseline, NamesALossOfAccuracyOfATwentieth) {
    const Results baseline = stored(noisy_passes(3, 0.01, 1.0, 0.1));
    const Results lost = pass_with(1.0, 1.0, 1.0, 0.105);
    const std::vector<Finding> findings = regressions(baseline, {&lost, 1}, Limits());
    ASSERT_EQ(findings.size(), 2U);
    EXPECT_EQ(findings[0].change, Change::kLessAccurate);
    const Results trifle = pass_with(1.0, 1.0, 1.0, 0.104);
    EXPECT_TRUE(regressions(baseline, {&trifle, 1}, Limits()).empty());
    const Results broken = pass_with(1.0, 1.0, 1.0, NAN);
    EXPECT_EQ(regressions(baseline, {&broken, 1}, Limits()).size(), 2U);
}

TEST(Calibration, TakesAFixedTimeOfAboutAMillisecond) {
    const double us = calibration_us();
    EXPECT_GT(us, 100.0);
    EXPECT_LT(us, 100'000.0);
}

}  // namespace
}  // namespace zoned::bench
