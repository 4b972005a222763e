// Conditioner: one direction of a bad network path (bottleneck, delay, jitter, loss, duplicates,
// reordering, outages), seeded, on the caller's clock.
#pragma once

#include "client-sim/link/bottleneck.h"
#include "client-sim/link/link.h"
#include "shared/core/rng.h"

#include <cstdint>
#include <unordered_map>

namespace zoned::link {

/// Semantics, per direction: the delay is uniform in [delay - jitter, delay + jitter], never below
/// zero; loss, duplicate and reorder are probabilities per datagram. A reordered datagram is held
/// back by a further 1..2 `reorder_hold_s`; jitter alone may reorder as well. During an outage [k *
/// every, k * every + length), k >= 1, all datagrams are lost; frames wait for its end. A
/// bottleneck comes first on the path: datagrams go through it in order, with their headers. A
/// datagram lost behind it has used it. Frames do not use it: TCP shares a link by its own rules,
/// which are not simulated here.
struct ConditionerSettings {
    double delay_s = 0.0;
    double jitter_s = 0.0;
    double loss = 0.0;       ///< 0..1
    double duplicate = 0.0;  ///< 0..1; the copy draws its own delay
    double reorder = 0.0;    ///< 0..1
    double reorder_hold_s = 1.0 / 30.0;
    double outage_every_s = 0.0;  ///< 0: never
    double outage_length_s = 0.0;
    double bottleneck_up_bytes_per_s = 0.0;  ///< client to server; 0: none
    double bottleneck_down_bytes_per_s = 0.0;
    double bottleneck_queue_s = 0.25;  ///< a datagram that would wait longer is dropped
    double header_bytes = 28.0;        ///< IP and UDP, per datagram in the bottleneck
    std::uint64_t seed = 1;

    /// Largest difference between one-way delays by these settings, bottlenecks and outages aside,
    /// s.
    [[nodiscard]] double spread_s() const {
        return 2.0 * jitter_s + (reorder > 0.0 ? 2.0 * reorder_hold_s : 0.0);
    }

    /// False when push and pop would pass everything through at once.
    [[nodiscard]] bool active() const {
        return delay_s > 0.0 || jitter_s > 0.0 || loss > 0.0 || duplicate > 0.0 || reorder > 0.0 ||
               outage_every_s > 0.0 || bottleneck_up_bytes_per_s > 0.0 ||
               bottleneck_down_bytes_per_s > 0.0;
    }
};

/// The bottleneck of a conditioner.
enum class Direction : std::uint8_t {
    kUp,
    kDown
};

/// A queue of messages with their due times. Datagrams and frames of one direction get one
/// conditioner each; frames are delayed in the same manner but never lost, doubled or reordered (a
/// stream repairs all that). Same settings, stream, times and messages: same result.
class Conditioner {
  public:
    enum class Mode : std::uint8_t {
        kDatagrams,
        kFrames
    };

    /// `stream` separates the random numbers of several conditioners of one seed.
    Conditioner(const ConditionerSettings& settings,
                Mode mode,
                std::uint64_t stream,
                Direction direction = Direction::kUp);

    void push(double now_s, Bytes message);
    /// Moves the next message that is due at `now_s` to `out`; false when there is none.
    bool pop_due(double now_s, Bytes& out);
    /// When the next message is due; infinity when none waits.
    [[nodiscard]] double next_due_s() const;

    /// Forgets all messages in flight (the stream was cut).
    void clear() { heap_.clear(); }

    /// From now on everything passes at once, past a bottleneck too. Messages in flight still take
    /// their time.
    void heal() { healed_ = true; }

    /// Changes the bottleneck, which must have been there from the beginning.
    void set_bottleneck(double now_s, double bytes_per_s);

    [[nodiscard]] BottleneckMeter bottleneck(double now_s) const {
        return bottleneck_.meter(now_s);
    }

    void restart_bottleneck_meter(double now_s) { bottleneck_.restart_meter(now_s); }

    [[nodiscard]] std::uint64_t lost() const { return lost_; }

    [[nodiscard]] std::uint64_t doubled() const { return doubled_; }

    [[nodiscard]] std::uint64_t held_back() const { return held_back_; }

  private:
    struct DelayedMessage {
        double due_s = 0.0;
        std::uint64_t order = 0;  // first in, first out among equal due times
        Bytes message;
    };

    /// The planned fate of a datagram in the bottleneck.
    struct PlannedDelivery {
        Bytes message;
        bool lost = false;
        double delay_s = 0.0;
        double copy_delay_s = -1.0;  // below 0: it is not doubled
    };

    [[nodiscard]] static bool later(const DelayedMessage& a, const DelayedMessage& b);
    [[nodiscard]] double draw_delay();
    [[nodiscard]] bool chance(double probability);
    void insert(double due_s, Bytes message);
    void travel(double from_s, PlannedDelivery planned);
    void serve(double now_s);

    ConditionerSettings settings_;
    Mode mode_;
    core::Rng rng_;
    Bottleneck bottleneck_;
    std::unordered_map<std::uint64_t, PlannedDelivery> queued_;  // in the bottleneck, by number
    std::uint64_t entered_ = 0;
    bool healed_ = false;
    std::vector<DelayedMessage> heap_;
    std::uint64_t order_ = 0;
    double last_due_s_ = 0.0;
    std::uint64_t lost_ = 0;
    std::uint64_t doubled_ = 0;
    std::uint64_t held_back_ = 0;
};

}  // namespace zoned::link
