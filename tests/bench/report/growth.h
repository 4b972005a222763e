// Growth: how the time of a method grows with the size of its scene.
#pragma once

#include "tests/bench/results.h"

#include <string>
#include <vector>

namespace zoned::bench {

struct SizedTime {
    double size = 0.0;
    double time_us = 0.0;
};

/// time = factor * size^exponent.
struct PowerFit {
    double exponent = 0.0;
    double factor = 0.0;
    double low = 0.0;   ///< of the exponent, 95 %
    double high = 0.0;  ///< of the exponent, 95 %
};

/// Least squares of logarithms; the interval is Student's with n - 2 degrees of freedom (Draper and
/// Smith, "Applied Regression Analysis", 3rd edition, section 1.4). It covers scatter about a power
/// law: a bend shows as a wide interval. Wants at least three different sizes, all > 0.
PowerFit fit_power(const std::vector<SizedTime>& times);

struct GrowthSeries {
    const Row* first = nullptr;    ///< names method and peer
    std::vector<SizedTime> times;  ///< by rising size
    PowerFit fit;
};

/// The methods of one scene over its sizes.
struct Growth {
    std::string suite;
    std::string scene;
    std::string size_name;  ///< "n", "entities", ...
    std::string parameter;  ///< without the size
    std::vector<GrowthSeries> series;

    [[nodiscard]] std::string heading() const;
};

/// Scenes whose parameter names a size ("n=1000 all move"), with at least three sizes.
std::vector<Growth> growths_of(const Results& results);

}  // namespace zoned::bench
