// Baseline: ratios of our defaults to a yardstick of the same run, kept in the tree.
#pragma once

#include "tests/bench/compare/judgement.h"
#include "tests/bench/results.h"

#include <span>
#include <string>
#include <vector>

namespace zoned::bench {

/// The time of a default over its yardstick: the first peer's default in the same scene, else the
/// calibration kernel beside the scene. A ratio holds on machines that are faster throughout.
struct DefaultRatio {
    const Row* row = nullptr;
    double ratio = 0.0;
    bool by_peer = false;
};

/// Of all timed default rows that have a yardstick. They point into `results`.
std::vector<DefaultRatio> default_ratios(const Results& results);

/// Rows with the metrics `ratio` (the median over the passes), `spread` (the standard deviation of
/// its logarithm, from the median absolute deviation), `by_peer` (1 or 0) and `error_largest` (the
/// absolute error of the worst pass). Only rows that all passes have.
Results baseline_of(std::span<const Results> passes);

/// The findings that are worse than a baseline. A time is named where the median over the passes
/// lies beyond the threshold and beyond three spreads of the baseline; an error where the least
/// over the passes is a loss beyond the worst one of the baseline. Rows that only one of the two
/// has don't count.
std::vector<Finding> regressions(const Results& baseline,
                                 std::span<const Results> passes,
                                 const Limits& limits);

/// How many rows of the first pass the baseline knows.
std::size_t rows_in_common(const Results& baseline, const Results& pass);

}  // namespace zoned::bench
