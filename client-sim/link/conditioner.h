// Conditioner: one direction of a bad network path (delay, jitter, loss, duplicates, reordering,
// outages), seeded, on whatever clock the caller passes in.
#pragma once

#include "client-sim/link/link.h"
#include "shared/core/rng.h"

#include <cstdint>

namespace zoned::link {

/// Semantics, per direction: the delay is uniform in [delay - jitter, delay + jitter], never below
/// zero; loss, duplicate and reorder are probabilities per datagram. A reordered datagram is held
/// back by a further 1..2 `reorder_hold_s`; jitter alone may reorder as well. During an outage
/// [k * every, k * every + length), k >= 1, all datagrams are lost; frames wait for its end.
struct ConditionerSettings {
    double delay_s = 0.0;
    double jitter_s = 0.0;
    double loss = 0.0;       ///< 0..1
    double duplicate = 0.0;  ///< 0..1; the copy draws its own delay
    double reorder = 0.0;    ///< 0..1
    double reorder_hold_s = 1.0 / 30.0;
    double outage_every_s = 0.0;  ///< 0: never
    double outage_length_s = 0.0;
    std::uint64_t seed = 1;

    /// False when push and pop would hand everything through at once.
    [[nodiscard]] bool active() const {
        return delay_s > 0.0 || jitter_s > 0.0 || loss > 0.0 || duplicate > 0.0 || reorder > 0.0 ||
               outage_every_s > 0.0;
    }
};

/// A queue of messages with their due times. Datagrams and frames of one direction get one
/// conditioner each; frames are delayed alike but never lost, doubled or reordered (a stream
/// repairs all that). Same settings, stream, times and messages: same result.
class Conditioner {
  public:
    enum class Mode : std::uint8_t {
        kDatagrams,
        kFrames
    };

    /// `stream` tells the random numbers of several conditioners of one seed apart.
    Conditioner(const ConditionerSettings& settings, Mode mode, std::uint64_t stream);

    void push(double now_s, Bytes message);
    /// Moves the next message that is due at `now_s` to `out`; false when there is none.
    bool pop_due(double now_s, Bytes& out);
    /// When the next message is due; infinity when none waits.
    [[nodiscard]] double next_due_s() const;

    /// Forgets what is under way (the stream was cut).
    void clear() { heap_.clear(); }

    [[nodiscard]] std::uint64_t lost() const { return lost_; }

    [[nodiscard]] std::uint64_t doubled() const { return doubled_; }

    [[nodiscard]] std::uint64_t held_back() const { return held_back_; }

  private:
    struct Waiting {
        double due_s = 0.0;
        std::uint64_t order = 0;  // first in, first out among equal due times
        Bytes message;
    };

    [[nodiscard]] static bool later(const Waiting& a, const Waiting& b);
    [[nodiscard]] double draw_delay();
    [[nodiscard]] bool chance(double probability);
    void insert(double due_s, Bytes message);

    ConditionerSettings settings_;
    Mode mode_;
    core::Rng rng_;
    std::vector<Waiting> heap_;
    std::uint64_t order_ = 0;
    double last_due_s_ = 0.0;
    std::uint64_t lost_ = 0;
    std::uint64_t doubled_ = 0;
    std::uint64_t held_back_ = 0;
};

}  // namespace zoned::link
