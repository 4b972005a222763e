// RankStatistics: tests and intervals that hold for heavy-tailed times, and corrections for many.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

namespace zoned::bench {

/// Wilcoxon's signed-rank test: how likely values that lie symmetrically around `centre` have a sum
/// of positive ranks at least as large. Exact, with mid-ranks for ties; values equal to the centre
/// do not count; 1 for no values. (Wilcoxon, "Individual Comparisons by Ranking Methods",
/// Biometrics Bulletin 1, 1945; Hollander and Wolfe, "Nonparametric Statistical Methods", 2nd
/// edition, section 3.1.)
double signed_rank_p(std::span<const double> values, double centre);

struct Location {
    double middle = 0.0;
    double low = 0.0;
    double high = 0.0;
};

/// The median of the averages of all pairs, and the interval around it that inverts the signed-rank
/// test: at least 95 %, as far as the number of values allows. Zeros for no values. (Hodges and
/// Lehmann, "Estimates of Location Based on Rank Tests", Annals of Mathematical Statistics 34,
/// 1963; Hollander and Wolfe, sections 3.2 and 3.3.)
Location hodges_lehmann(std::span<const double> values);

/// p values such that rejecting those below a level keeps the chance of any false rejection below
/// it, whatever their dependence. (Holm, "A Simple Sequentially Rejective Multiple Test Procedure",
/// Scandinavian Journal of Statistics 6, 1979.)
std::vector<double> holm(std::span<const double> p);

}  // namespace zoned::bench
