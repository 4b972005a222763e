#include "tests/bench/compare/rank_statistics.h"

#include "tests/bench/statistics.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace zoned::bench {

namespace {

/// The chances of all sums of a random half of the ranks; sums count in halves of a rank, so that
/// mid-ranks are whole.
std::vector<double> chances_of_sums(std::span<const std::size_t> doubled_ranks) {
    const std::size_t most =
        std::accumulate(doubled_ranks.begin(), doubled_ranks.end(), std::size_t{0});
    std::vector<double> chances(most + 1, 0.0);
    chances[0] = 1.0;
    std::size_t reach = 0;
    for (const std::size_t rank : doubled_ranks) {
        reach += rank;
        for (std::size_t sum = reach + 1; sum-- > 0;) {
            chances[sum] = 0.5 * (chances[sum] + (sum >= rank ? chances[sum - rank] : 0.0));
        }
    }
    return chances;
}

/// Twice the mid-rank of each size.
std::vector<std::size_t> doubled_mid_ranks(const std::vector<double>& sizes) {
    std::vector<std::size_t> order(sizes.size());
    std::iota(order.begin(), order.end(), std::size_t{0});
    std::sort(order.begin(), order.end(), [&sizes](std::size_t a, std::size_t b) {
        return sizes[a] < sizes[b];
    });
    std::vector<std::size_t> ranks(sizes.size());
    for (std::size_t first = 0; first < order.size();) {
        std::size_t end = first + 1;
        while (end < order.size() && sizes[order[end]] == sizes[order[first]]) {
            ++end;
        }
        for (std::size_t i = first; i < end; ++i) {
            ranks[order[i]] = first + end + 1;  // twice the mean of first + 1 ... end
        }
        first = end;
    }
    return ranks;
}

}  // namespace

double signed_rank_p(std::span<const double> values, double centre) {
    std::vector<double> sizes;
    std::vector<bool> above;
    for (const double value : values) {
        if (value != centre) {
            sizes.push_back(std::abs(value - centre));
            above.push_back(value > centre);
        }
    }
    const std::vector<std::size_t> ranks = doubled_mid_ranks(sizes);
    std::size_t sum = 0;
    for (std::size_t i = 0; i < ranks.size(); ++i) {
        sum += above[i] ? ranks[i] : 0;
    }
    const std::vector<double> chances = chances_of_sums(ranks);
    return std::accumulate(chances.begin() + static_cast<std::ptrdiff_t>(sum), chances.end(), 0.0);
}

Location hodges_lehmann(std::span<const double> values) {
    if (values.empty()) {
        return {};
    }
    std::vector<double> averages;
    std::vector<std::size_t> ranks;
    for (std::size_t i = 0; i < values.size(); ++i) {
        ranks.push_back(2 * (i + 1));
        for (std::size_t j = i; j < values.size(); ++j) {
            averages.push_back(0.5 * (values[i] + values[j]));
        }
    }
    std::sort(averages.begin(), averages.end());
    // As many averages lie outside on each side as the sum of ranks is with a chance of 2.5 %.
    const std::vector<double> chances = chances_of_sums(ranks);
    std::size_t outside = 0;
    double chance = 0.0;
    while (2 * outside + 2 < averages.size()) {
        chance += chances[2 * outside];
        if (chance > 0.025) {
            break;
        }
        ++outside;
    }
    outside = outside == 0 ? 0 : outside - 1;
    return {median(averages), averages[outside], averages[averages.size() - 1 - outside]};
}

std::vector<double> holm(std::span<const double> p) {
    std::vector<std::size_t> order(p.size());
    std::iota(order.begin(), order.end(), std::size_t{0});
    std::sort(
        order.begin(), order.end(), [&p](std::size_t a, std::size_t b) { return p[a] < p[b]; });
    std::vector<double> adjusted(p.size());
    double most = 0.0;
    for (std::size_t i = 0; i < order.size(); ++i) {
        most = std::max(most, std::min(1.0, static_cast<double>(p.size() - i) * p[order[i]]));
        adjusted[order[i]] = most;
    }
    return adjusted;
}

}  // namespace zoned::bench
