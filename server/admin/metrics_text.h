// MetricsText: writes figures in the text format of Prometheus, version 0.0.4.
#pragma once

#include <initializer_list>
#include <string>
#include <string_view>
#include <utility>

namespace zoned::admin {

/// The type of the format, for Content-Type.
inline constexpr const char* kMetricsType = "text/plain; version=0.0.4; charset=utf-8";

/// Format: Prometheus, "Exposition formats". The caller gives each family once, and each set of
/// labels once within it.
class MetricsText {
  public:
    using Labels = std::initializer_list<std::pair<std::string_view, std::string_view>>;

    /// Begins a family; `type` is counter, gauge or summary. The samples of counters end in _total.
    void family(std::string_view name, std::string_view type, std::string_view help);
    /// A sample of the family.
    void sample(double value, Labels labels = {});
    /// A sample of the family whose name goes on, as _sum and _count of a summary do.
    void sample_of(std::string_view suffix, double value);

    /// A family with one sample.
    void single(std::string_view name, std::string_view type, std::string_view help, double value) {
        family(name, type, help);
        sample(value);
    }

    [[nodiscard]] const std::string& text() const { return text_; }

  private:
    void number(double value);

    std::string name_;
    std::string text_;
};

}  // namespace zoned::admin
