#include "client-sim/view/playout.h"

#include <algorithm>
#include <cmath>

namespace zoned::view {

namespace {

/// Number of ticks, about, within which a difference to the target delay is slewed away, if kSlew
/// allows.
constexpr double kSettleTicks = 8.0;

}  // namespace

Tick Playout::lead_ticks(double tick_s) {
    return std::max<Tick>(1, std::lround(kLeadS / tick_s));
}

void Playout::on_update(Tick lateness) {
    const auto value = static_cast<std::uint8_t>(std::clamp<Tick>(lateness, 0, kMaxDelay));
    std::uint8_t& slot = lateness_[samples_ % kSamples];
    if (samples_ >= kSamples) {
        --count_[slot];
    }
    slot = value;
    ++count_[value];
    ++samples_;
    const auto known = static_cast<double>(std::min(samples_, kSamples));
    const auto wanted = static_cast<std::size_t>(std::ceil(kTarget * known));
    std::size_t sum = 0;
    for (std::size_t i = 0; i < count_.size(); ++i) {
        sum += count_[i];
        if (sum >= wanted) {
            delay_ = static_cast<Tick>(i) + lead_;
            return;
        }
    }
}

void Playout::advance(Tick view_tick) {
    if (samples_ == 0) {
        return;
    }
    const auto target = static_cast<double>(view_tick - delay_);
    const bool first = view_tick_ < 0;
    const double before = position_;
    const double error = target - (position_ + 1.0);
    if (first || error > kJump) {
        position_ = first ? target : std::max(target, position_);
    } else {
        position_ += 1.0 + std::clamp(error / kSettleTicks, -kSlew, kSlew);
    }
    view_tick_ = view_tick;
    const auto last = static_cast<Tick>(std::floor(position_));
    // Skipped ticks were not displayed.
    const Tick from = first || error > kJump ? last : static_cast<Tick>(std::floor(before)) + 1;
    for (Tick tick = from; tick <= last; ++tick) {
        if (tick >= 0) {
            shown_[static_cast<std::size_t>(tick) % shown_.size()] = {tick, view_tick};
        }
    }
}

std::optional<Tick> Playout::shown_at(Tick tick) const {
    if (tick < 0) {
        return std::nullopt;
    }
    const Shown& shown = shown_[static_cast<std::size_t>(tick) % shown_.size()];
    return shown.tick == tick ? std::optional<Tick>(shown.view_tick) : std::nullopt;
}

}  // namespace zoned::view
