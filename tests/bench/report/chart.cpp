#include "tests/bench/report/chart.h"

#include "shared/core/json.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>

namespace zoned::bench {

namespace {

std::string id_from(const std::string& prefix, const std::string& heading) {
    std::string id = prefix;
    for (const char c : heading) {
        const bool plain =
            (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9');
        if (plain || id.back() != '-') {
            id += plain ? c : '-';
        }
    }
    return id;
}

std::string whose(Role role) {
    switch (role) {
        case Role::kDefault:
            return "our default";
        case Role::kOwn:
            return "ours";
        case Role::kPeer:
            return "peer";
    }
    return "";
}

std::string error_label(const Figure& figure) {
    if (figure.error_unit == "-") {
        return "error, 1";  // of a number without a unit
    }
    return "error" + (figure.error_unit.empty() ? "" : ", " + figure.error_unit);
}

std::string position_of(const FigurePoint& point) {
    if (!point.aside.empty()) {
        return "not compared: " + point.aside;
    }
    if (point.factor == 1.0) {
        return "on it";
    }
    return short_number(std::round(point.factor * 100.0) / 100.0) + " times";
}

ChartSeries& series_of(Chart& chart, const Row& row, bool line) {
    const std::string name = method_name(row);
    auto at = std::find_if(chart.series.begin(),
                           chart.series.end(),
                           [&name](const ChartSeries& series) { return series.name == name; });
    if (at == chart.series.end()) {
        at = chart.series.insert(chart.series.end(), ChartSeries{name, role_of(row), line, {}});
    }
    return *at;
}

const FigurePoint* point_of(const Figure& figure, const Row* row) {
    const auto at = std::find_if(figure.points.begin(),
                                 figure.points.end(),
                                 [row](const FigurePoint& point) { return point.row == row; });
    return at == figure.points.end() ? nullptr : &*at;
}

std::string table_name(const Row& row, bool with_parameter) {
    return method_name(row) +
           (with_parameter && !row.parameter.empty() ? ", " + row.parameter : "");
}

const double* bytes_of(const Row& row) {
    const double* const wire = row.find_metric("wire_bytes_per_s");
    return wire != nullptr ? wire : row.find_metric("bytes_per_s");
}

std::string front_summary(const Figure& figure) {
    std::string names;
    for (const FigurePoint* point : front_of(figure)) {
        const std::string name = method_name(*point->row);
        if ((", " + names + ",").find(", " + name + ",") == std::string::npos) {
            names += (names.empty() ? "" : ", ") + name;
        }
    }
    return std::to_string(figure.points.size()) +
           " points. On the front: " + (names.empty() ? "none" : names) + ".";
}

/// More than a plot shows; all digits would be a tenth of the page.
double five_digits(double value) {
    std::array<char, 32> text{};
    std::snprintf(text.data(), text.size(), "%.5g", value);
    return std::strtod(text.data(), nullptr);
}

void write_points(core::JsonWriter& json, const std::vector<ChartPoint>& points) {
    json.begin_array();
    for (const ChartPoint& point : points) {
        json.begin_object();
        json.field("x", five_digits(point.x)).field("y", five_digits(point.y));
        json.field("n", point.number).field("t", point.text);
        json.end_object();
    }
    json.end_array();
}

}  // namespace

std::string short_number(double value) {
    if (!std::isfinite(value)) {
        return "-";
    }
    std::array<char, 32> text{};
    std::snprintf(text.data(), text.size(), "%.4g", value);
    return text.data();
}

std::string command_of(const Figure& figure, const Results& results) {
    std::string command = "zoned-bench " + figure.suite + " --scene " + figure.run_scene;
    for (std::size_t i = 0; i < results.methods.size(); ++i) {
        command += (i == 0 ? " --method " : ",") + results.methods[i];
    }
    if (results.repeats > 0) {
        command += " --repeat " + std::to_string(results.repeats);
    }
    return command + (results.quick ? " --quick" : "");
}

Chart chart_of(const Figure& figure, const Results& results) {
    Chart chart;
    chart.id = id_from("plot-", figure.heading() + " " + figure.error_unit);
    chart.title = figure.heading();
    chart.summary = front_summary(figure);
    chart.command = command_of(figure, results);
    chart.x_label = error_label(figure);
    chart.y_label = figure.time_label;
    const bool curves = !figure.along_label.empty();
    chart.columns = {
        "", "method", "whose", "time, us", "p99, us", error_label(figure), "time over the front"};
    int number = 0;
    for (const Row* row : figure.rows) {
        const FigurePoint* const point = point_of(figure, row);
        const std::string label = table_name(*row, curves);
        if (point != nullptr) {
            ++number;
            series_of(chart, *row, curves)
                .points.push_back(
                    {point->error,
                     point->time_us,
                     number,
                     label + ": " + error_label(figure) + " " + short_number(point->error) + ", " +
                         short_number(point->time_us) + " us; front: " + position_of(*point)});
        }
        chart.table.push_back({point == nullptr ? "" : std::to_string(number),
                               label,
                               whose(role_of(*row)),
                               short_number(point == nullptr ? row->time_us_p50 : point->time_us),
                               short_number(row->time_us_p99),
                               short_number(row->error),
                               point != nullptr            ? position_of(*point)
                               : std::isfinite(row->error) ? "not timed"
                                                           : "no finite error"});
    }
    for (const FigurePoint* point : front_of(figure)) {
        chart.front.push_back({point->error, point->time_us, 0, ""});
    }
    return chart;
}

Chart along_chart_of(const Figure& figure, const Results& results) {
    Chart chart;
    chart.id = id_from("along-", figure.heading() + " " + figure.error_unit);
    chart.title = figure.heading() + ": error against " + figure.along_label;
    chart.summary = std::to_string(figure.points.size()) + " points.";
    chart.command = command_of(figure, results);
    chart.x_label = figure.along_label;
    chart.y_label = error_label(figure);
    chart.columns = {"", "method", "whose", figure.along_label, error_label(figure)};
    int number = 0;
    for (const FigurePoint& point : figure.points) {
        ++number;
        const std::string label = table_name(*point.row, true);
        series_of(chart, *point.row, true)
            .points.push_back({point.along,
                               point.error,
                               number,
                               label + ": " + figure.along_label + " " + short_number(point.along) +
                                   ", error " + short_number(point.error)});
        chart.table.push_back({std::to_string(number),
                               label,
                               whose(role_of(*point.row)),
                               short_number(point.along),
                               short_number(point.error)});
    }
    return chart;
}

Chart chart_of(const Growth& growth, const Results& results) {
    Chart chart;
    chart.id = id_from("growth-", growth.heading() + " " + growth.size_name);
    chart.title = growth.heading() + ": time against " + growth.size_name;
    chart.x_label = growth.size_name;
    chart.y_label = "microseconds";
    Figure figure;
    figure.suite = growth.suite;
    figure.run_scene = growth.scene;
    chart.command = command_of(figure, results);
    chart.columns = {
        "", "method", "whose", "sizes", "exponent", "95 % interval", "time at the largest, us"};
    int number = 0;
    for (const GrowthSeries& series : growth.series) {
        ++number;
        const std::string name = method_name(*series.first);
        const std::string exponent = short_number(std::round(series.fit.exponent * 1e3) / 1e3);
        const std::string interval = short_number(std::round(series.fit.low * 1e3) / 1e3) + " to " +
                                     short_number(std::round(series.fit.high * 1e3) / 1e3);
        for (const SizedTime& time : series.times) {
            series_of(chart, *series.first, true)
                .points.push_back({time.size,
                                   time.time_us,
                                   number,
                                   name + ": " + growth.size_name + " " + short_number(time.size) +
                                       ", " + short_number(time.time_us) + " us"});
        }
        chart.table.push_back({std::to_string(number),
                               name,
                               whose(role_of(*series.first)),
                               short_number(series.times.front().size) + " to " +
                                   short_number(series.times.back().size),
                               exponent,
                               interval,
                               short_number(series.times.back().time_us)});
        chart.summary += name + " grows with the power " + exponent + ". ";
    }
    return chart;
}

Chart bandwidth_chart_of(const Figure& figure, const Results& results) {
    Chart chart;
    chart.id = id_from("bytes-", figure.heading() + " " + figure.error_unit);
    chart.title = figure.heading() + ": bandwidth against error";
    chart.command = command_of(figure, results);
    chart.x_label = error_label(figure);
    chart.y_label = "bytes a second";
    chart.columns = {"", "method", "whose", error_label(figure), "bytes a second"};
    int number = 0;
    for (const Row* row : figure.rows) {
        const double* const bytes = bytes_of(*row);
        if (bytes == nullptr || !(*bytes > 0.0) || !std::isfinite(row->error)) {
            continue;
        }
        ++number;
        const bool curves = !figure.along_label.empty();
        const std::string label = table_name(*row, curves);
        series_of(chart, *row, curves)
            .points.push_back({std::abs(row->error),
                               *bytes,
                               number,
                               label + ": error " + short_number(std::abs(row->error)) + ", " +
                                   short_number(*bytes) + " bytes a second"});
        chart.table.push_back({std::to_string(number),
                               label,
                               whose(role_of(*row)),
                               short_number(row->error),
                               short_number(*bytes)});
    }
    chart.summary = std::to_string(number) + " points.";
    return chart;
}

std::string chart_json(const Chart& chart) {
    core::JsonWriter json;
    json.begin_object();
    json.field("id", chart.id).field("x", chart.x_label).field("y", chart.y_label);
    json.key("series").begin_array();
    for (const ChartSeries& series : chart.series) {
        json.begin_object();
        json.field("name", series.name).field("line", series.line);
        json.field("role",
                   series.role == Role::kDefault ? "default"
                   : series.role == Role::kOwn   ? "own"
                                                 : "peer");
        json.key("points");
        write_points(json, series.points);
        json.end_object();
    }
    json.end_array();
    json.key("front");
    write_points(json, chart.front);
    json.end_object();
    // Indentation would be a third of the page.
    std::string text;
    bool in_text = false;
    for (std::size_t i = 0; i < json.text().size(); ++i) {
        const char c = json.text()[i];
        in_text = c == '"' && (i == 0 || json.text()[i - 1] != '\\') ? !in_text : in_text;
        if (in_text || (c != '\n' && c != ' ')) {
            text += c;
        }
    }
    return text;
}

}  // namespace zoned::bench
