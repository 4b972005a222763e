#include "tests/bench/plot.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>

namespace zoned::bench {

namespace {

constexpr double kWidth = 640.0;
constexpr double kHeight = 400.0;
constexpr double kLeft = 80.0;
constexpr double kRight = 150.0;  // room for the labels of the rightmost points
constexpr double kTop = 40.0;
constexpr double kBottom = 50.0;

std::string format(const char* pattern, double a, double b = 0.0, double c = 0.0, double d = 0.0) {
    std::array<char, 256> text{};
    std::snprintf(text.data(), text.size(), pattern, a, b, c, d);
    return text.data();
}

std::string escaped(const std::string& text) {
    std::string out;
    for (const char c : text) {
        switch (c) {
            case '<':
                out += "&lt;";
                break;
            case '>':
                out += "&gt;";
                break;
            case '&':
                out += "&amp;";
                break;
            case '"':
                out += "&quot;";
                break;
            default:
                out += c;
        }
    }
    return out;
}

bool has_size(double value) {
    return std::isfinite(value) && value != 0.0;
}

/// Whole decades around the values that have a logarithm.
class LogAxis {
  public:
    LogAxis(const std::vector<double>& values, double start, double end)
        : start_(start),
          end_(end) {
        bool any = false;
        for (const double value : values) {
            if (has_size(value)) {
                const double decade = std::log10(std::abs(value));
                lower_ = any ? std::min(lower_, std::floor(decade)) : std::floor(decade);
                upper_ = any ? std::max(upper_, std::ceil(decade)) : std::ceil(decade);
                any = true;
            }
        }
        upper_ = std::max(upper_, lower_ + 1.0);
    }

    [[nodiscard]] double place(double value) const {
        const double decade = has_size(value) ? std::log10(std::abs(value)) : lower_;
        return start_ + (end_ - start_) * (decade - lower_) / (upper_ - lower_);
    }

    [[nodiscard]] int lower() const { return static_cast<int>(lower_); }

    [[nodiscard]] int upper() const { return static_cast<int>(upper_); }

  private:
    double start_;
    double end_;
    double lower_ = 0.0;
    double upper_ = 1.0;
};

std::string label_at(double x, double y, const char* anchor, const std::string& text) {
    return format("<text x=\"%.1f\" y=\"%.1f\" ", x, y) + "text-anchor=\"" + anchor + "\">" +
           escaped(text) + "</text>\n";
}

std::string grid(const LogAxis& x, const LogAxis& y) {
    constexpr const char* kLine =
        "<line x1=\"%.1f\" y1=\"%.1f\" x2=\"%.1f\" y2=\"%.1f\" stroke=\"#ddd\"/>\n";
    std::string text;
    for (int decade = x.lower(); decade <= x.upper(); ++decade) {
        const double at = x.place(std::pow(10.0, decade));
        text += format(kLine, at, kTop, at, kHeight - kBottom);
        text += label_at(at, kHeight - kBottom + 16.0, "middle", format("1e%.0f", decade));
    }
    for (int decade = y.lower(); decade <= y.upper(); ++decade) {
        const double at = y.place(std::pow(10.0, decade));
        text += format(kLine, kLeft, at, kWidth - kRight, at);
        text += label_at(kLeft - 6.0, at + 4.0, "end", format("1e%.0f", decade));
    }
    return text;
}

struct PlotSpot {
    double x;
    double y;
    double label_y;
    const Point* point;
};

/// Moves labels down until none overlaps another.
void part_labels(std::vector<PlotSpot>& spots) {
    constexpr double kLine = 13.0;
    constexpr double kLabel = 120.0;  // width of the longest
    std::sort(
        spots.begin(), spots.end(), [](const PlotSpot& a, const PlotSpot& b) { return a.y < b.y; });
    for (std::size_t i = 0; i < spots.size(); ++i) {
        for (std::size_t j = 0; j < i; ++j) {
            const bool beside = std::abs(spots[i].x - spots[j].x) < kLabel;
            if (beside && spots[i].label_y < spots[j].label_y + kLine) {
                spots[i].label_y = spots[j].label_y + kLine;
            }
        }
    }
}

std::string number(double value) {
    return std::isfinite(value) ? format("%.5g", value) : "-";
}

std::string name_of(const Row& row) {
    return row.peer.empty() ? row.method : row.peer + "/" + row.method;
}

/// The axes for rows with a certain metric: time and that metric.
struct CurveKind {
    const char* metric;
    const char* metric_label;
    const char* time_label;
    bool times_metric;  ///< time_us_p50 is the time of one of these units
};

/// The kind of curve that a row is a point of, or null.
const CurveKind* curve_of(const Row& row) {
    static constexpr std::array<CurveKind, 3> kKinds{{
        {"passes", "passes", "microseconds of a solve", false},
        {"steps_per_s", "steps of a second", "microseconds of a simulated second", true},
        {"updates_per_s", "publications a second", "microseconds of a tick", false},
    }};
    const auto found = std::find_if(kKinds.begin(), kKinds.end(), [&row](const CurveKind& kind) {
        return row.find_metric(kind.metric) != nullptr;
    });
    return found == kKinds.end() ? nullptr : found;
}

/// The first word of a curve's parameter varies along the curve.
std::string heading_of(const Row& row) {
    std::string parameter = row.parameter;
    if (curve_of(row) != nullptr) {
        const std::size_t blank = parameter.find(' ');
        parameter = blank == std::string::npos ? "" : parameter.substr(blank + 1);
    }
    return row.suite + " " + row.scene + (parameter.empty() ? "" : " " + parameter);
}

const char* colour(std::size_t i) {
    constexpr std::array<const char*, 9> kColours{
        "#06c", "#c30", "#393", "#939", "#c80", "#066", "#888", "#630", "#f6a"};
    return kColours[i % kColours.size()];
}

std::string table_html(const std::vector<const Row*>& rows) {
    std::string text =
        "<table><tr><th>method</th><th>parameter</th><th>us p50</th><th>us p99</th><th>error</th>"
        "<th>metrics</th></tr>\n";
    for (const Row* row : rows) {
        text += "<tr><td>" + escaped(name_of(*row)) + "</td><td>" + escaped(row->parameter) +
                "</td><td>" + number(row->time_us_p50) + "</td><td>" + number(row->time_us_p99) +
                "</td><td>" + number(row->error) + " " + escaped(row->error_unit) + "</td><td>";
        for (const auto& [name, value] : row->metrics) {
            text += escaped(name) + "=" + number(value) + " ";
        }
        text += "</td></tr>\n";
    }
    return text + "</table>\n";
}

}  // namespace

std::string scatter_svg(const std::string& title,
                        const std::string& x_label,
                        const std::string& y_label,
                        const std::vector<Point>& points) {
    std::vector<double> xs;
    std::vector<double> ys;
    for (const Point& point : points) {
        xs.push_back(point.x);
        ys.push_back(point.y);
    }
    const LogAxis x(xs, kLeft, kWidth - kRight);
    const LogAxis y(ys, kHeight - kBottom, kTop);
    std::string svg = format(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"%.0f\" height=\"%.0f\" "
        "font-family=\"sans-serif\" font-size=\"12\">\n",
        kWidth,
        kHeight);
    svg += "<rect width=\"100%\" height=\"100%\" fill=\"white\"/>\n" + grid(x, y);
    svg += label_at(kLeft, kTop - 16.0, "start", title);
    svg += label_at(0.5 * (kLeft + kWidth - kRight), kHeight - 12.0, "middle", x_label);
    svg += label_at(8.0, kTop - 16.0, "start", y_label);
    std::vector<PlotSpot> spots;
    for (const Point& point : points) {
        spots.push_back({x.place(point.x), y.place(point.y), y.place(point.y), &point});
    }
    part_labels(spots);
    for (const PlotSpot& spot : spots) {
        svg += format("<circle cx=\"%.1f\" cy=\"%.1f\" r=\"4\" stroke=\"#06c\" ", spot.x, spot.y);
        svg += spot.point->own ? "fill=\"#06c\"/>\n" : "fill=\"none\"/>\n";
        svg += label_at(spot.x + 7.0, spot.label_y + 4.0, "start", spot.point->label);
    }
    return svg + "</svg>\n";
}

std::string curves_svg(const std::string& x_label,
                       const std::string& y_label,
                       const std::vector<Point>& points) {
    std::vector<double> xs;
    std::vector<double> ys;
    for (const Point& point : points) {
        xs.push_back(point.x);
        ys.push_back(point.y);
    }
    const LogAxis x(xs, kLeft, kWidth - kRight);
    const LogAxis y(ys, kHeight - kBottom, kTop);
    std::string svg = format(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"%.0f\" height=\"%.0f\" "
        "font-family=\"sans-serif\" font-size=\"12\">\n",
        kWidth,
        kHeight);
    svg += "<rect width=\"100%\" height=\"100%\" fill=\"white\"/>\n" + grid(x, y);
    svg += label_at(0.5 * (kLeft + kWidth - kRight), kHeight - 12.0, "middle", x_label);
    svg += label_at(8.0, kTop - 16.0, "start", y_label);
    std::vector<PlotSpot> ends;
    std::size_t curve = 0;
    for (std::size_t i = 0; i < points.size(); ++curve) {
        svg += std::string("<polyline fill=\"none\" stroke=\"") + colour(curve) + "\" points=\"";
        const std::string& label = points[i].label;
        std::size_t last = i;
        for (; i < points.size() && points[i].label == label; ++i) {
            svg += format("%.1f,%.1f ", x.place(points[i].x), y.place(points[i].y));
            last = i;
        }
        svg += "\"/>\n";
        const double at = y.place(points[last].y);
        ends.push_back({x.place(points[last].x), at, at, &points[last]});
    }
    part_labels(ends);
    for (const PlotSpot& spot : ends) {
        svg += label_at(spot.x + 5.0, spot.label_y + 4.0, "start", spot.point->label);
    }
    return svg + "</svg>\n";
}

std::string report_html(const Results& results) {
    std::string html =
        "<!DOCTYPE html>\n<html><head><meta charset=\"utf-8\"><title>zoned-bench</title>\n"
        "<style>body{font-family:sans-serif}td,th{text-align:left;padding:0 1em 0 0;"
        "vertical-align:top;font-size:80%}</style></head><body>\n<p>" +
        escaped(results.machine + "; " + results.build + "; commit " + results.commit) +
        (results.quick ? "; quick: scenes were cut short" : "") + "</p>\n";
    for (const std::string& note : results.notes) {
        html += "<p>" + escaped(note) + "</p>\n";
    }
    std::size_t i = 0;
    while (i < results.rows.size()) {
        const std::string heading = heading_of(results.rows[i]);
        std::vector<const Row*> rows;
        std::vector<Point> points;
        std::vector<Point> along;
        for (; i < results.rows.size() && heading_of(results.rows[i]) == heading; ++i) {
            const Row& row = results.rows[i];
            rows.push_back(&row);
            const CurveKind* curve = curve_of(row);
            if (curve == nullptr) {
                points.push_back({name_of(row), row.time_us_p50, row.error, row.peer.empty()});
            } else if (std::isfinite(row.error)) {  // exploded rows have no place
                const double at = *row.find_metric(curve->metric);
                const double time = row.time_us_p50 * (curve->times_metric ? at : 1.0);
                points.push_back({name_of(row), time, row.error, row.peer.empty()});
                along.push_back({name_of(row), at, row.error, row.peer.empty()});
            }
        }
        html += "<h2>" + escaped(heading) + "</h2>\n";
        const std::string unit = "error, " + rows[0]->error_unit;
        const CurveKind* curve = curve_of(*rows[0]);
        html += curve == nullptr ? scatter_svg("", "microseconds of a frame", unit, points)
                                 : curves_svg(curve->time_label, unit, points) +
                                       curves_svg(curve->metric_label, unit, along);
        html += table_html(rows);
    }
    for (const Drawing& picture : results.pictures) {
        html += "<h2>" + escaped(picture.caption) + "</h2>\n" + picture.svg;
    }
    return html + "</body></html>\n";
}

}  // namespace zoned::bench
