#include "server/admin/metrics_text.h"

#include <array>
#include <charconv>
#include <cmath>

namespace zoned::admin {

void MetricsText::family(std::string_view name, std::string_view type, std::string_view help) {
    name_ = name;
    text_ += "# HELP ";
    text_ += name;
    text_ += ' ';
    text_ += help;
    text_ += "\n# TYPE ";
    text_ += name;
    text_ += ' ';
    text_ += type;
    text_ += '\n';
}

void MetricsText::sample(double value, Labels labels) {
    text_ += name_;
    char separator = '{';
    for (const auto& [label, content] : labels) {
        text_ += separator;
        separator = ',';
        text_ += label;
        text_ += "=\"";
        for (const char c : content) {
            if (c == '\\' || c == '"') {
                text_ += '\\';
                text_ += c;
            } else if (c == '\n') {
                text_ += "\\n";
            } else {
                text_ += c;
            }
        }
        text_ += '"';
    }
    text_ += separator == ',' ? "} " : " ";
    number(value);
}

void MetricsText::sample_of(std::string_view suffix, double value) {
    text_ += name_;
    text_ += suffix;
    text_ += ' ';
    number(value);
}

void MetricsText::number(double value) {
    if (std::isnan(value)) {
        text_ += "NaN";
    } else if (std::isinf(value)) {
        text_ += value > 0.0 ? "+Inf" : "-Inf";
    } else {
        std::array<char, 32> digits{};
        const auto [end, error] =
            std::to_chars(digits.data(), digits.data() + digits.size(), value);
        text_.append(digits.data(), error == std::errc() ? end : digits.data());
    }
    text_ += '\n';
}

}  // namespace zoned::admin
