// RecentValues: the newest values of a figure, and their quantiles.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>

namespace zoned::library {

class RecentValues {
  public:
    static constexpr std::size_t kKept = 512;

    void add(double value) { values_[count_++ % kKept] = value; }

    /// Values so far, those that are forgotten included.
    [[nodiscard]] std::uint64_t count() const { return count_; }

    /// 0 before the first one.
    [[nodiscard]] double last() const { return count_ > 0 ? values_[(count_ - 1) % kKept] : 0.0; }

    /// The smallest value that at least this share of the kept ones does not exceed; 0 without any.
    [[nodiscard]] double quantile(double share) const {
        const auto kept = static_cast<std::size_t>(std::min<std::uint64_t>(count_, kKept));
        if (kept == 0) {
            return 0.0;
        }
        std::array<double, kKept> sorted = values_;
        std::sort(sorted.begin(), sorted.begin() + static_cast<std::ptrdiff_t>(kept));
        const double rank = share * static_cast<double>(kept) - 1.0;
        auto at = static_cast<std::size_t>(std::max(0.0, rank));
        at += rank > static_cast<double>(at) ? 1 : 0;
        return sorted[std::min(at, kept - 1)];
    }

  private:
    std::array<double, kKept> values_{};  // a ring
    std::uint64_t count_ = 0;
};

}  // namespace zoned::library
