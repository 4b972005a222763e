// News: how old the news of one entity can be, from the packets that carried it and those that
// came.
#pragma once

#include "client-sim/link/arrival_log.h"

#include <cstdint>
#include <vector>

namespace zoned::measure {

/// What the server says it did to tell of one entity. The default is: nothing but what the client
/// has acknowledged.
struct SentUpdates {
    struct Packet {
        Tick tick = 0;
        std::uint64_t sequence = 0;
    };

    Tick postponed_tick = 0;      ///< when its budget last made something of it wait; 0: never
    bool leaving = false;         ///< the packets carry its removal
    std::vector<Packet> packets;  ///< ascending: those with news that were not acknowledged
};

/// D of one entity by the promised bound: a delay and a tick, and one resend (round trip and tick)
/// where the newest news of this entity was lost, `around` being what holds for all news at that
/// time. Where it was lost more than once, each further loss adds one resend, but D is then no more
/// than what has really gone by since the first packet that the client missed left: until then what
/// it held was within its bound.
///
/// A loss is a fact that both sides know: the server names the packet (it can't name one that came,
/// as it came; nor one that it never sent, as then no number is missing), and how long it may take
/// until it sends again is not the server's to say.
///
/// `complete`: the server can name all packets that matter; else a loss of any packet counts as one
/// of this entity's news. `tick`: of the truth; `shown_s`: when it was displayed, in the time of
/// the log.
link::UpdateAge age_of(const link::UpdateAge& around,
                       const SentUpdates& sent_updates,
                       bool complete,
                       const link::ArrivalLog& log,
                       Tick tick,
                       double shown_s,
                       double rtt_s,
                       double tick_s);

}  // namespace zoned::measure
