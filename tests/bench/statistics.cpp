#include "tests/bench/statistics.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numeric>

namespace zoned::bench {

double quantile(std::span<const double> values, double share) {
    if (values.empty()) {
        return 0.0;
    }
    std::vector<double> sorted(values.begin(), values.end());
    std::sort(sorted.begin(), sorted.end());
    const double place = std::clamp(share, 0.0, 1.0) * static_cast<double>(sorted.size() - 1);
    const auto below = static_cast<std::size_t>(std::floor(place));
    const std::size_t above = std::min(below + 1, sorted.size() - 1);
    return std::lerp(sorted[below], sorted[above], place - static_cast<double>(below));
}

double median(std::span<const double> values) {
    return quantile(values, 0.5);
}

double mean(std::span<const double> values) {
    if (values.empty()) {
        return 0.0;
    }
    return std::accumulate(values.begin(), values.end(), 0.0) / static_cast<double>(values.size());
}

double largest(std::span<const double> values) {
    return values.empty() ? 0.0 : *std::max_element(values.begin(), values.end());
}

std::vector<double> median_of_rows(std::span<const std::vector<double>> rows) {
    std::vector<double> result;
    if (rows.empty()) {
        return result;
    }
    std::vector<double> column(rows.size());
    for (std::size_t i = 0; i < rows.front().size(); ++i) {
        for (std::size_t r = 0; r < rows.size(); ++r) {
            column[r] = rows[r][i];
        }
        result.push_back(median(column));
    }
    return result;
}

}  // namespace zoned::bench
