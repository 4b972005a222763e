// Plots: run time against error as SVG, for reports.
#pragma once

#include "tests/bench/results.h"

#include <string>
#include <vector>

namespace zoned::bench {

struct Point {
    std::string label;
    double x = 0.0;
    double y = 0.0;
    bool own = false;  ///< ours: drawn filled, peers hollow
};

/// A picture with logarithmic axes. The absolute value counts; zero and non-finite values lie on
/// the lower edge. Labels are escaped.
std::string scatter_svg(const std::string& title,
                        const std::string& x_label,
                        const std::string& y_label,
                        const std::vector<Point>& points);

/// The points of one label are joined by a line in their order, and labelled once.
std::string curves_svg(const std::string& x_label,
                       const std::string& y_label,
                       const std::vector<Point>& points);

/// One page of all rows: a picture of time against error per scene, and the metrics as tables; then
/// the pictures of scenes.
/// Rows with the metric `passes` are points of one curve per method, whatever the first word of
/// their parameter: error against time and against passes. Rows with `updates_per_s` are drawn in
/// the same manner. So are those with the metric `steps_per_s`, whose time is that of one step:
/// error against the time of a simulated second and against its steps.
std::string report_html(const Results& results);

}  // namespace zoned::bench
