// Statistics: order statistics of measured values.
#pragma once

#include <span>
#include <vector>

namespace zoned::bench {

/// The value below which `share` (0..1) of the values lie, by linear interpolation between order
/// statistics; 0 for no values.
double quantile(std::span<const double> values, double share);

/// quantile(values, 0.5).
double median(std::span<const double> values);

/// 0 for no values.
double mean(std::span<const double> values);

/// The largest value; 0 for no values.
double largest(std::span<const double> values);

/// Element by element the median over the rows, which all have the same length.
std::vector<double> median_of_rows(std::span<const std::vector<double>> rows);

}  // namespace zoned::bench
