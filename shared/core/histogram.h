// Histogram: counts of durations or sizes in buckets of at most 1.6 % width; bounded memory for any
// length of run.
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>

namespace zoned::core {

/// Non-negative integers, exact below 64, then 64 buckets per power of two (as HdrHistogram does,
/// G. Tene).
class Histogram {
  public:
    void add(std::uint64_t value) {
        ++counts_[index(value)];
        ++count_;
        sum_ += value;
        max_ = std::max(max_, value);
    }

    [[nodiscard]] std::uint64_t count() const { return count_; }

    [[nodiscard]] std::uint64_t sum() const { return sum_; }

    [[nodiscard]] std::uint64_t max() const { return max_; }

    /// The smallest bucket's upper edge below or at which `share` (0..1] of the values lie, never
    /// above max(); 0 when empty.
    [[nodiscard]] std::uint64_t quantile(double share) const {
        const double wanted = share * static_cast<double>(count_);
        std::uint64_t seen = 0;
        for (std::size_t i = 0; i < counts_.size(); ++i) {
            seen += counts_[i];
            if (counts_[i] != 0 && static_cast<double>(seen) >= wanted) {
                return std::min(upper_edge(i), max_);
            }
        }
        return max_;
    }

  private:
    static constexpr unsigned kSubBits = 6;
    static constexpr std::size_t kBuckets = (64 - kSubBits + 1) << kSubBits;

    static std::size_t index(std::uint64_t value) {
        if (value < (1u << kSubBits)) {
            return static_cast<std::size_t>(value);
        }
        const auto top = static_cast<unsigned>(std::bit_width(value)) - 1;
        const std::uint64_t sub = (value >> (top - kSubBits)) - (1u << kSubBits);
        return ((static_cast<std::size_t>(top) - kSubBits + 1) << kSubBits) +
               static_cast<std::size_t>(sub);
    }

    static std::uint64_t upper_edge(std::size_t i) {
        if (i < (1u << kSubBits)) {
            return i;
        }
        const auto top = static_cast<unsigned>(i >> kSubBits) - 1 + kSubBits;
        const std::uint64_t sub = (i & ((1u << kSubBits) - 1)) + (1u << kSubBits);
        return ((sub + 1) << (top - kSubBits)) - 1;
    }

    std::array<std::uint32_t, kBuckets> counts_{};
    std::uint64_t count_ = 0;
    std::uint64_t sum_ = 0;
    std::uint64_t max_ = 0;
};

}  // namespace zoned::core
