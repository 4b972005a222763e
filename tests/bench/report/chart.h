// Chart: one plot with logarithmic axes and its table, as data for the page.
#pragma once

#include "tests/bench/report/front.h"
#include "tests/bench/report/growth.h"

#include <string>
#include <vector>

namespace zoned::bench {

struct ChartPoint {
    double x = 0.0;
    double y = 0.0;
    int number = 0;    ///< of its row in the table, from 1
    std::string text;  ///< read out by a screen reader
};

struct ChartSeries {
    std::string name;
    Role role = Role::kOwn;
    bool line = false;
    std::vector<ChartPoint> points;
};

struct Chart {
    std::string id;  ///< of its element, unique on the page
    std::string title;
    std::string summary;  ///< one or two sentences, in place of the plot for those who can't see it
    std::string command;  ///< measures it again
    std::string x_label;
    std::string y_label;
    std::vector<ChartSeries> series;
    std::vector<ChartPoint> front;  ///< empty: none is drawn
    std::vector<std::string> columns;
    std::vector<std::vector<std::string>> table;
};

/// Run time against error, with the front; curves where the figure has them.
Chart chart_of(const Figure& figure, const Results& results);

/// Error against passes, steps or publications; only for figures with curves.
Chart along_chart_of(const Figure& figure, const Results& results);

/// Time against size, with the exponent of each method in the table.
Chart chart_of(const Growth& growth, const Results& results);

/// Bytes a second against error, for rows of a figure with the metric `wire_bytes_per_s` or
/// `bytes_per_s`; without series where there are none.
Chart bandwidth_chart_of(const Figure& figure, const Results& results);

/// The chart as a JSON object for the page's script.
std::string chart_json(const Chart& chart);

/// Four digits; "-" for what is not finite.
std::string short_number(double value);

/// "zoned-bench SUITE --scene SCENE ..." with the options of the run.
std::string command_of(const Figure& figure, const Results& results);

}  // namespace zoned::bench
