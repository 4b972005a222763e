// Histogram: percentiles of any number of samples in bounded memory.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

namespace zoned::core {

/// Logarithmic buckets, 32 per power of two: a percentile is off by at most 1.1 % of its value
/// (half a bucket). Samples below 2^-30 count as zero, samples above 2^30 as the largest bucket;
/// maximum and mean are exact.
class Histogram {
  public:
    void add(double value);
    /// As if all samples of `other` had been added here.
    void merge(const Histogram& other);

    [[nodiscard]] std::uint64_t count() const { return count_; }

    [[nodiscard]] double max() const { return max_; }

    [[nodiscard]] double mean() const {
        return count_ > 0 ? sum_ / static_cast<double>(count_) : 0.0;
    }

    /// The value below which a share `p` (0..1) of the samples lies; 0 without samples.
    [[nodiscard]] double percentile(double p) const;

  private:
    static constexpr int kPerOctave = 32;
    static constexpr int kOctaves = 60;
    static constexpr int kLowestExponent = -30;
    std::array<std::uint64_t, kPerOctave * kOctaves> buckets_{};
    std::uint64_t zeros_ = 0;
    std::uint64_t count_ = 0;
    double max_ = 0.0;
    double sum_ = 0.0;
};

}  // namespace zoned::core
