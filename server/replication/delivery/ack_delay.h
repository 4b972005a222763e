// AckDelay: how late acknowledgements of one client come, and so when a packet is lost and when a
// probe is due.
#pragma once

#include "shared/core/ids.h"
#include "shared/core/state_hash.h"

#include <algorithm>
#include <cstdint>
#include <vector>

namespace zoned::replication {

/// Late is not lost: a client or server that is short of CPU answers late, and packets sent again
/// for that would take still more of it. So time alone decides nothing here but when to probe.
///
/// *Reordering.* A packet is passed over when so many later ones arrived that reordering does not
/// explain it (RFC 9002, section 6.1.1). The tolerance grows when a packet given up is acknowledged
/// after all, as RACK's window does (RFC 8985, section 6.2). It is forgotten after two seconds
/// without such an event.
///
/// *Probes.* Acknowledgements are overdue when they are later than the path's round trips and their
/// variation explain, and later than any of the last one to two seconds. That is a maximum and no
/// variance: delays here are few ticks, whose spread is bounded. Without any acknowledgement the
/// time doubles (RFC 9002, section 6.2.1).
///
/// *Spurious resends.* Acknowledgements name packets, so the one of a packet given up proves that
/// it was only late (Eifel, RFC 3522). Its age counts as a delay like any other.
///
/// *Lateness.* Acknowledgements are late while the latest of the last seconds took more than twice
/// as long as the soonest of the last minute, and twenty ticks: something is overloaded. A stall of
/// less says nothing yet.
///
/// Ages are those that a tick sees: waiting for the client's next datagram, and for the tick, is in
/// them. Deterministic.
class AckDelay {
  public:
    struct Acked {
        std::uint64_t sequence = 0;
        Tick sent_tick = 0;
        std::uint64_t overtaken_by = 0;  ///< packets; 0: none that is newer was acknowledged before
        bool given_up = false;
        bool outage = false;  ///< the client was away: its delay says nothing
    };

    /// A packet's first acknowledgement. Counts from the next begin_tick() on.
    void on_acked(const Acked& acked);

    /// `patience`: wire::resend_timeout_ticks of the path, `round_trip`: wire::round_trip_ticks.
    void begin_tick(Tick now, float tick_s, Tick patience, Tick round_trip);

    /// Whether a packet is lost when one sent `later` packets later was acknowledged.
    [[nodiscard]] bool passed_over(std::uint64_t later, Tick age) const {
        return later >= tolerance_ || age > reordered_after();
    }

    /// Whether a packet after which nothing was acknowledged is to be probed for.
    [[nodiscard]] bool probe(Tick now, Tick age);

    /// Whether acknowledgements come much later than the path alone explains.
    [[nodiscard]] bool late() const {
        const Tick usual = std::min(soonest_now_, soonest_before_);
        return usual < kNever && delay_.value() > 2 * usual + kLateTicks;
    }

    void hash(core::StateHash& hash) const;

    static constexpr std::uint64_t kLeastTolerance = 3;  ///< RFC 9002, kPacketThreshold
    static constexpr std::uint64_t kMostTolerance = 32;  ///< acknowledgements reach no farther back
    static constexpr int kMostDoublings = 6;

    template <class Archive>
    void serialize(Archive& archive) {
        archive(fresh_, delay_.now, delay_.before, reordered_.now, reordered_.before, tolerance_);
        archive(tolerance_tick_, period_tick_, patience_, round_trip_, probe_tick_, doublings_);
        archive(soonest_now_, soonest_before_, soonest_tick_);
    }

  private:
    /// The maximum over the last one to two seconds.
    struct RecentMax {
        Tick now = 0;
        Tick before = 0;

        void add(Tick value) { now = value > now ? value : now; }

        [[nodiscard]] Tick value() const { return now > before ? now : before; }
    };

    [[nodiscard]] Tick reordered_after() const;
    [[nodiscard]] Tick overdue_after() const;

    static constexpr Tick kLateTicks = 20;
    static constexpr Tick kNever = 1 << 30;

    std::vector<Acked> fresh_;  // since the last tick
    RecentMax delay_;           // of packets that came in order
    RecentMax reordered_;       // of packets that were overtaken
    std::uint64_t tolerance_ = kLeastTolerance;
    Tick tolerance_tick_ = 0;  // when it last grew
    Tick period_tick_ = 0;     // when the present second began
    Tick patience_ = 1;
    Tick round_trip_ = 1;
    Tick soonest_now_ = kNever;  // least delay of this half minute ...
    Tick soonest_before_ = kNever;
    Tick soonest_tick_ = 0;  // ... which began then
    Tick probe_tick_ = -1;   // when the present round of probes began; -1: none
    int doublings_ = 0;
};

}  // namespace zoned::replication
