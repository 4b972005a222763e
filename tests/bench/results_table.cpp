#include "tests/bench/results.h"

#include <algorithm>
#include <array>
#include <cstdio>

namespace zoned::bench {

namespace {

std::string four_digits(double value) {
    std::array<char, 32> text{};
    std::snprintf(text.data(), text.size(), "%.4g", value);
    return text.data();
}

std::vector<std::string> cells(const Row& row) {
    const double* bullet = row.find_metric("bullet_ratio");
    const double* yardstick = row.find_metric("y_ratio");
    return {row.suite,
            row.scene,
            row.parameter,
            row.peer.empty() ? row.method : row.peer + "/" + row.method,
            four_digits(row.time_us_p50),
            four_digits(row.time_us_p99),
            bullet != nullptr ? four_digits(*bullet) : "",
            yardstick != nullptr ? four_digits(*yardstick) : "",
            four_digits(row.error),
            row.error_unit};
}

constexpr std::size_t kFirstNumber = 4;
constexpr std::size_t kLastNumber = 8;

std::string padded(const std::string& text, std::size_t width, bool right) {
    const std::string space(width - std::min(width, text.size()), ' ');
    return right ? space + text : text + space;
}

}  // namespace

std::string to_table(const Results& results) {
    std::vector<std::vector<std::string>> lines{{"suite",
                                                 "scene",
                                                 "parameter",
                                                 "method",
                                                 "us p50",
                                                 "us p99",
                                                 "/bullet",
                                                 "/Y",
                                                 "error",
                                                 ""}};
    for (const Row& row : results.rows) {
        lines.push_back(cells(row));
    }
    std::vector<std::size_t> widths(lines.front().size(), 0);
    for (const auto& line : lines) {
        for (std::size_t c = 0; c < line.size(); ++c) {
            widths[c] = std::max(widths[c], line[c].size());
        }
    }
    std::string text;
    for (const auto& line : lines) {
        std::string out;
        for (std::size_t c = 0; c < line.size(); ++c) {
            out += padded(line[c], widths[c], c >= kFirstNumber && c <= kLastNumber) + "  ";
        }
        out.erase(out.find_last_not_of(' ') + 1);
        text += out + "\n";
    }
    for (const std::string& note : results.notes) {
        text += "note: " + note + "\n";
    }
    return text;
}

std::string to_metrics_table(const Results& results) {
    std::string text;
    for (const Row& row : results.rows) {
        text += row.scene + (row.parameter.empty() ? "" : " " + row.parameter) + " " +
                (row.peer.empty() ? row.method : row.peer + "/" + row.method) + ":";
        for (const auto& [name, value] : row.metrics) {
            text += " " + name + "=" + four_digits(value);
        }
        text += "\n";
    }
    return text;
}

}  // namespace zoned::bench
