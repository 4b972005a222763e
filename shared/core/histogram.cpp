#include "shared/core/histogram.h"

#include <algorithm>
#include <cmath>

namespace zoned::core {

void Histogram::add(double value) {
    if (!std::isfinite(value)) {
        value = std::ldexp(1.0, kLowestExponent + kOctaves);
    }
    value = std::max(value, 0.0);
    ++count_;
    sum_ += value;
    max_ = std::max(max_, value);
    int exponent = 0;
    const double fraction = std::frexp(value, &exponent);  // value = fraction * 2^exponent
    const int octave = exponent - 1 - kLowestExponent;
    if (value == 0.0 || octave < 0) {
        ++zeros_;
        return;
    }
    const int within =
        std::min(kPerOctave - 1, static_cast<int>((fraction * 2.0 - 1.0) * kPerOctave));
    const int index = std::min(octave * kPerOctave + within, kPerOctave * kOctaves - 1);
    ++buckets_[static_cast<std::size_t>(index)];
}

void Histogram::merge(const Histogram& other) {
    for (std::size_t i = 0; i < buckets_.size(); ++i) {
        buckets_[i] += other.buckets_[i];
    }
    zeros_ += other.zeros_;
    count_ += other.count_;
    max_ = std::max(max_, other.max_);
    sum_ += other.sum_;
}

double Histogram::percentile(double p) const {
    if (count_ == 0) {
        return 0.0;
    }
    const auto rank = static_cast<std::uint64_t>(
        std::clamp(std::ceil(p * static_cast<double>(count_)), 1.0, static_cast<double>(count_)));
    std::uint64_t below = zeros_;
    if (rank <= below) {
        return 0.0;
    }
    for (int i = 0; i < kPerOctave * kOctaves; ++i) {
        below += buckets_[static_cast<std::size_t>(i)];
        if (rank <= below) {
            const double lower = std::ldexp(1.0 + static_cast<double>(i % kPerOctave) / kPerOctave,
                                            i / kPerOctave + kLowestExponent);
            const double width = std::ldexp(1.0 / kPerOctave, i / kPerOctave + kLowestExponent);
            return std::min(lower + 0.5 * width, max_);
        }
    }
    return max_;
}

}  // namespace zoned::core
