#include "shared/clock/input_lead.h"

#include "shared/core/elementary/elementary.h"

#include <algorithm>
#include <cmath>

namespace zoned::clock {

namespace {

/// The first lead stays until this many travel times are known.
constexpr std::size_t kLeastSamples = 8;
/// This many travel times are enough to know the longest. With fewer, late commands are expected.
constexpr std::size_t kLearning = 128;
/// Share of the allowed late commands that is aimed at.
constexpr double kAim = 1.0 / 1.3;
/// Beside it: scheduling at both ends.
constexpr double kMarginS = 0.003;
constexpr double kRaiseTicks = 0.25;  // for a command that was missed
constexpr double kMostFeedbackTicks = 4.0;
constexpr double kShownTicks =
    4.0;  // beside a round trip: until the server has seen a change of the lead
constexpr double kRisingS = 0.5e-3;
constexpr double kNegligibleLoss = 0.002;

/// Share of (longest - median) of n travel times to add, so that the next one is longer with kAim
/// times the target only. Of an exponential tail of scale s the longest is about s ln(n) above the
/// median, and s ln(1 / (n p)) more are needed for p; other tails are thinner.
double beyond_longest(std::size_t n) {
    const auto count = static_cast<double>(n);
    const double wanted = elementary::log(1.0 / (kAim * InputLead::kMissingTarget * count));
    return std::clamp(wanted / elementary::log(count), 0.0, 1.0);
}

}  // namespace

void InputLead::begin(double rtt_s, double now_s) {
    begun_ = true;
    last_s_ = now_s;
    lead_ = std::clamp(0.5 * rtt_s + tick_s_, 0.0, most_s());
    wanted_ = lead_;
}

void InputLead::add_path(double path_s, int late) {
    path_s += tick_s_ * static_cast<double>(late);
    if (!(std::abs(path_s) <= most_s())) {
        return;
    }
    paths_[count_ % kSamples] = path_s;
    ++count_;
    // The longest shows at once, the rest of the picture changes slowly.
    if (count_ >= kLeastSamples && (count_ >= next_measure_ || path_s + kMarginS > wanted_)) {
        measure();
        next_measure_ = count_ + kLeastSamples;
    }
}

void InputLead::measure() {
    const std::size_t n = std::min(count_, kSamples);
    std::copy_n(paths_.begin(), n, sorted_.begin());
    const auto middle = sorted_.begin() + static_cast<std::ptrdiff_t>(n / 2);
    const auto end = sorted_.begin() + static_cast<std::ptrdiff_t>(n);
    std::nth_element(sorted_.begin(), middle, end);
    const double share = loss_ > kNegligibleLoss ? kMissingUnderLoss : 0.0;
    const auto spared = static_cast<std::size_t>(share * static_cast<double>(n));
    const auto rank = end - 1 - static_cast<std::ptrdiff_t>(std::min(spared, n / 2));
    std::nth_element(middle, rank, end);
    const double longest = *rank;
    // Nothing more is needed of the scatter that loss makes: what is spared is not to be in time.
    const double scatter = spared == 0 ? beyond_longest(n) * (longest - *middle) : 0.0;
    wanted_ = std::clamp(longest + scatter + kMarginS + feedback_s_, 0.0, most_s());
}

void InputLead::on_feedback(bool missing, double rtt_s) {
    const bool learning = count_ > 0 && count_ < kLearning;
    if (missing && (learning || last_s_ - rising_s_ < rtt_s + kShownTicks * tick_s_)) {
        return;
    }
    const double step = kRaiseTicks * tick_s_;
    const double before = feedback_s_;
    const double target = loss_ > kNegligibleLoss ? kMissingUnderLoss : kMissingTarget;
    feedback_s_ += missing ? step : -step * target / (1.0 - target);
    feedback_s_ = std::clamp(feedback_s_, 0.0, kMostFeedbackTicks * tick_s_);
    wanted_ = std::clamp(wanted_ + feedback_s_ - before, 0.0, most_s());
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
