#include "shared/clock/input_lead.h"

#include <algorithm>
#include <cmath>

namespace zoned::clock {

namespace {

/// Before so many ways are known the first lead stays.
constexpr std::size_t kLeastSamples = 8;
/// The longest way above the median, of which so much is added.
constexpr double kScatterShare = 0.15;
/// Beside it: scheduling at both ends.
constexpr double kMarginS = 0.003;
constexpr double kRaiseTicks = 0.25;  // for a command that was missed
constexpr double kMostToldTicks = 4.0;
constexpr double kShownTicks = 4.0;  // beside a round trip: until a change of the lead is told
constexpr double kRisingS = 0.5e-3;
constexpr double kNegligibleLoss = 0.002;

}  // namespace

void InputLead::begin(double rtt_s, double now_s) {
    begun_ = true;
    last_s_ = now_s;
    lead_ = std::clamp(0.5 * rtt_s + tick_s_, 0.0, most_s());
    wanted_ = lead_;
}

void InputLead::add_way(double way_s) {
    if (!(std::abs(way_s) <= most_s())) {
        return;
    }
    ways_[count_ % kSamples] = way_s;
    ++count_;
    // The longest shows at once, the rest of the picture changes slowly.
    if (count_ >= kLeastSamples && (count_ >= next_measure_ || way_s + kMarginS > wanted_)) {
        measure();
        next_measure_ = count_ + kLeastSamples;
    }
}

void InputLead::measure() {
    const std::size_t n = std::min(count_, kSamples);
    std::copy_n(ways_.begin(), n, sorted_.begin());
    const auto middle = sorted_.begin() + static_cast<std::ptrdiff_t>(n / 2);
    const auto end = sorted_.begin() + static_cast<std::ptrdiff_t>(n);
    std::nth_element(sorted_.begin(), middle, end);
    const double longest = *std::max_element(middle, end);
    // Lost with its packet, a command comes with the next that is not lost.
    int ticks = 0;
    for (double late = loss_ > kNegligibleLoss ? loss_ : 0.0;
         late > kMissingUnderLoss && ticks < kMostLossTicks;
         late *= loss_) {
        ++ticks;
    }
    wanted_ = std::clamp(longest + kScatterShare * (longest - *middle) + kMarginS +
                             static_cast<double>(ticks) * tick_s_ + told_,
                         0.0,
                         most_s());
}

void InputLead::on_told(bool missing, double rtt_s) {
    if (missing && last_s_ - rising_s_ < rtt_s + kShownTicks * tick_s_) {
        return;
    }
    const double step = kRaiseTicks * tick_s_;
    const double before = told_;
    told_ += missing ? step : -step * kMissingTarget / (1.0 - kMissingTarget);
    told_ = std::clamp(told_, 0.0, kMostToldTicks * tick_s_);
    wanted_ = std::clamp(wanted_ + told_ - before, 0.0, most_s());
}

double InputLead::advance(double now_s) {
    const double slewed = kSlew * std::max(0.0, now_s - last_s_);
    last_s_ = std::max(last_s_, now_s);
    if (wanted_ - lead_ > kRisingS) {
        rising_s_ = now_s;
    }
    lead_ += std::clamp(wanted_ - lead_, -slewed, slewed);
    return lead_;
}

}  // namespace zoned::clock
