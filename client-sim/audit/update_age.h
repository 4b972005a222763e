// update_age: the greatest age of one entity's updates, from the packets sent with them and the
// packets received.
#pragma once

#include "client-sim/link/arrival_log.h"
#include "shared/clock/round_trip.h"

#include <cstdint>
#include <vector>

namespace zoned::audit {

/// The server's report of the packets that carry one entity. The default: none but acknowledged
/// ones.
struct SentUpdates {
    struct Packet {
        Tick tick = 0;
        std::uint64_t sequence = 0;
    };

    Tick postponed_tick = 0;  ///< when the budget last delayed one of its updates; 0: never
    bool leaving = false;     ///< the packets carry its removal
    std::vector<Packet>
        packets;  ///< ascending: packets with its updates that were not acknowledged
};

/// D of one entity by the promised bound: a delay and a tick, and one resend (round trip and tick)
/// where the newest update of this entity was lost. `around` is the age of all updates at that
/// time. A resend may be later, as the server acts at ticks (wire::resend_timeout_ticks), and each
/// further loss adds one. But D is then at most the time since the first packet that the client
/// missed left: until then the client's state was within its bound.
///
/// Both sides know a loss, so the server cannot invent one. It names the packet, but a packet that
/// came is not lost, and a packet that was never sent leaves no gap in the numbers. The server does
/// not choose the time allowed for a resend either.
///
/// `complete`: the server can name all packets that matter; otherwise a loss of any packet counts
/// as a loss of this entity's updates. `tick`: of the truth; `shown_s`: when it was displayed, in
/// the time of the log.
link::UpdateAge age_of(const link::UpdateAge& around,
                       const SentUpdates& sent_updates,
                       bool complete,
                       const link::ArrivalLog& log,
                       Tick tick,
                       double shown_s,
                       const clock::RoundTrip& path,
                       double tick_s);

}  // namespace zoned::audit
