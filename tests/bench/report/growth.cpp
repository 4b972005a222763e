#include "tests/bench/report/growth.h"

#include "tests/bench/report/front.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <set>
#include <sstream>
#include <tuple>

namespace zoned::bench {

namespace {

/// Two-sided 95 % of Student's distribution, by degrees of freedom from 1.
double student_95(std::size_t freedom) {
    constexpr std::array<double, 20> kQuantiles{12.706, 4.303, 3.182, 2.776, 2.571, 2.447, 2.365,
                                                2.306,  2.262, 2.228, 2.201, 2.179, 2.160, 2.145,
                                                2.131,  2.120, 2.110, 2.101, 2.093, 2.086};
    return freedom <= kQuantiles.size() ? kQuantiles[freedom - 1] : 1.96 + 2.5 / freedom;
}

struct Sized {
    std::string name;
    double size = 0.0;
    std::string rest;
};

/// A parameter's first size; no name where it has none.
Sized size_in(const std::string& parameter) {
    constexpr std::array<const char*, 7> kNames{
        "n", "entities", "awake", "people", "bodies", "agents", "zones"};
    Sized sized;
    std::istringstream words(parameter);
    for (std::string word; words >> word;) {
        const std::size_t equals = word.find('=');
        const std::string name = word.substr(0, equals);
        const bool known = std::find(kNames.begin(), kNames.end(), name) != kNames.end();
        if (sized.name.empty() && equals != std::string::npos && known) {
            sized.name = name;
            sized.size = std::strtod(word.c_str() + equals + 1, nullptr);
        } else {
            sized.rest += (sized.rest.empty() ? "" : " ") + word;
        }
    }
    return sized;
}

GrowthSeries& series_for(Growth& growth, const Row& row) {
    auto at = std::find_if(
        growth.series.begin(), growth.series.end(), [&row](const GrowthSeries& series) {
            return method_name(*series.first) == method_name(row);
        });
    if (at == growth.series.end()) {
        at = growth.series.insert(growth.series.end(), GrowthSeries{&row, {}, {}});
    }
    return *at;
}

bool is_short(const GrowthSeries& series) {
    std::set<double> sizes;
    for (const SizedTime& time : series.times) {
        sizes.insert(time.size);
    }
    return sizes.size() < 3;
}

}  // namespace

PowerFit fit_power(const std::vector<SizedTime>& times) {
    const auto n = static_cast<double>(times.size());
    double x_mean = 0.0;
    double y_mean = 0.0;
    for (const SizedTime& time : times) {
        x_mean += std::log(time.size) / n;
        y_mean += std::log(time.time_us) / n;
    }
    double xx = 0.0;
    double xy = 0.0;
    double yy = 0.0;
    for (const SizedTime& time : times) {
        const double x = std::log(time.size) - x_mean;
        const double y = std::log(time.time_us) - y_mean;
        xx += x * x;
        xy += x * y;
        yy += y * y;
    }
    const double slope = xy / xx;
    const double left = std::max(yy - slope * xy, 0.0) / (n - 2.0);
    const double half = student_95(times.size() - 2) * std::sqrt(left / xx);
    return {slope, std::exp(y_mean - slope * x_mean), slope - half, slope + half};
}

std::string Growth::heading() const {
    return suite + ": " + scene + (parameter.empty() ? "" : ", " + parameter);
}

std::vector<Growth> growths_of(const Results& results) {
    std::vector<Growth> growths;
    for (const Row& row : results.rows) {
        const Sized sized = size_in(row.parameter);
        if (sized.name.empty() || !(sized.size > 0.0) || !(row.time_us_p50 > 0.0)) {
            continue;
        }
        auto at = std::find_if(growths.begin(), growths.end(), [&](const Growth& g) {
            return std::tie(g.suite, g.scene, g.size_name, g.parameter) ==
                   std::tie(row.suite, row.scene, sized.name, sized.rest);
        });
        if (at == growths.end()) {
            at = growths.insert(growths.end(),
                                Growth{row.suite, row.scene, sized.name, sized.rest, {}});
        }
        series_for(*at, row).times.push_back({sized.size, row.time_us_p50});
    }
    for (Growth& growth : growths) {
        std::erase_if(growth.series, is_short);
        for (GrowthSeries& series : growth.series) {
            std::sort(series.times.begin(),
                      series.times.end(),
                      [](const SizedTime& a, const SizedTime& b) { return a.size < b.size; });
            series.fit = fit_power(series.times);
        }
    }
    std::erase_if(growths, [](const Growth& growth) { return growth.series.empty(); });
    return growths;
}

}  // namespace zoned::bench
