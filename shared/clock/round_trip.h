// RoundTrip: the smoothed round trip of a path and its variation, from samples.
#pragma once

#include <algorithm>
#include <cmath>

namespace zoned::clock {

/// A round trip without the peer's own time.
struct RoundTrip {
    double smoothed_s = 0.0;
    double variation_s = 0.0;  ///< mean deviation of samples
    double longest_s = 0.0;    ///< of the last two to four seconds; 0: not measured

    constexpr RoundTrip() = default;

    // Where only the round trip is known, it is taken to be steady.
    constexpr RoundTrip(double smoothed, double variation = 0.0)
        : smoothed_s(smoothed),
          variation_s(variation) {}
};

/// RFC 9002, section 5.3 (as RFC 6298, section 2, for TCP). The first sample is taken as it is with
/// half of it as its variation. Then come an eighth of each new sample and a quarter of each new
/// deviation.
class RoundTripEstimator {
  public:
    /// `sample_s` >= 0: the time that the peer kept the answer back is not in it. `now_s` ascends.
    void add(double sample_s, double now_s) {
        if (now_s - period_s_ >= kPeriod_s) {
            before_s_ = now_s - period_s_ < 2.0 * kPeriod_s ? longest_s_ : 0.0;
            longest_s_ = 0.0;
            period_s_ = now_s;
        }
        longest_s_ = std::max(longest_s_, sample_s);
        value_.longest_s = std::max(longest_s_, before_s_);
        if (!known_) {
            known_ = true;
            value_.smoothed_s = sample_s;
            value_.variation_s = 0.5 * sample_s;
            return;
        }
        value_.variation_s += (std::abs(value_.smoothed_s - sample_s) - value_.variation_s) / 4.0;
        value_.smoothed_s += (sample_s - value_.smoothed_s) / 8.0;
    }

    [[nodiscard]] bool known() const { return known_; }

    /// Zeros before the first sample.
    [[nodiscard]] const RoundTrip& value() const { return value_; }

  private:
    static constexpr double kPeriod_s = 2.0;

    RoundTrip value_;
    double longest_s_ = 0.0;  // since period_s_
    double before_s_ = 0.0;   // in the period before
    double period_s_ = -1e9;
    bool known_ = false;
};

}  // namespace zoned::clock
