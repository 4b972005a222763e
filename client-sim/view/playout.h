// Playout: the clock of an interpolating view. It displays a tick so far in the past that nearly
// all updates of that tick have come.
#pragma once

#include "shared/core/ids.h"

#include <array>
#include <cstdint>
#include <optional>

namespace zoned::view {

/// An adaptive jitter buffer for states. Dead reckoning makes publications sparse, but not late:
/// until the next publication the prediction is within its bound. So the view's delay follows the
/// lateness of updates, not the time between publications.
///
/// The view keeps the lateness of the last kSamples packets. It is the lateness of the oldest
/// update in each, so that resends and a tight budget count. The view stays behind by the kTarget
/// quantile of it: the histogram method of Moon, Kurose and Towsley, "Packet audio playout delay
/// adjustment: performance bounds and algorithms" (Multimedia Systems 6, 1998), section 4, which
/// follows spikes without the tuning that moving averages need (Ramjee et al., INFOCOM 1994, whose
/// fourth algorithm it improves on). It stays kLeadS farther back, so that it sees the next
/// publication coming and can lead to it without a jump. The clock slews towards that delay by at
/// most kSlew: it never stands still and never runs backwards; it jumps, ahead only, when it is
/// kJump ticks behind.
class Playout {
  public:
    static constexpr std::size_t kSamples = 256;
    static constexpr double kTarget = 0.99;
    static constexpr double kLeadS = 1.0 / 15.0;
    static constexpr double kSlew = 0.1;
    static constexpr double kJump = 30.0;
    /// Updates that are later than this belong to an outage.
    static constexpr Tick kMaxDelay = 60;

    /// kLeadS in whole ticks, at least one.
    static Tick lead_ticks(double tick_s);

    explicit Playout(double tick_s) : lead_(lead_ticks(tick_s)), delay_(lead_) {}

    /// The oldest update of a packet came `lateness` ticks after its own tick. That is the first
    /// view tick that can use it less the tick that it describes.
    void on_update(Tick lateness);

    /// The view reached its next tick (of the server's clock), one after the other; after a larger
    /// step the clock jumps. Nothing happens before the first update.
    void advance(Tick view_tick);

    /// The delay that the view aims at, ticks.
    [[nodiscard]] Tick delay() const { return delay_; }

    /// The displayed tick, with its fraction; nothing before the first advance().
    [[nodiscard]] double position() const { return position_; }

    [[nodiscard]] bool running() const { return view_tick_ >= 0; }

    /// View tick at which `tick` was displayed; none when it was not displayed (yet), was skipped
    /// or is forgotten.
    [[nodiscard]] std::optional<Tick> shown_at(Tick tick) const;

  private:
    struct Shown {
        Tick tick = -1;
        Tick view_tick = -1;
    };

    std::array<std::uint8_t, kSamples> lateness_{};
    std::array<std::uint16_t, kMaxDelay + 1> count_{};  // of lateness_, by value
    std::size_t samples_ = 0;
    std::array<Shown, 256> shown_{};
    Tick lead_;
    Tick delay_;
    Tick view_tick_ = -1;
    double position_ = 0.0;
};

}  // namespace zoned::view
