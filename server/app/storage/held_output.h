// HeldOutput: what the world tells clients for good waits here until no crash can undo it.
#pragma once

#include "server/mailbox/messages.h"

#include <cstdint>
#include <deque>
#include <utility>

namespace zoned::app {

/// The store's receipt for a tick's requests.
struct StoreTicket {
    std::uint64_t number = 0;  ///< durable when the store has come to it; 0: nothing waits
    bool refused = false;      ///< the store took none of them
};

/// For one thread. A durable event waits for the store. With a journal, all events and what else is
/// told once wait until their tick's inputs are in it, and leave in the order in which the world
/// made them, so that a recovered server numbers them alike. States and audits never wait.
class HeldOutput {
  public:
    static constexpr std::uint16_t kWithdrawnEvent = 11;  ///< proto::CORE_EVENT_WITHDRAWN

    /// From here on the output waits for the journal too.
    void await_journal(Tick kept) {
        journals_ = true;
        kept_ = kept;
    }

    /// Calls `send(item)` now, or when what it waits for has come.
    template <class Send>
    void take(const mailbox::OutboxItem& item, Tick tick, const StoreTicket& ticket, Send send) {
        const auto* event = std::get_if<mailbox::EventOut>(&item);
        const bool durable = event != nullptr && event->durable;
        if (durable && ticket.refused) {
            // Its news were not stored, and rules hear so.
            ++refused_;
            if (journals_) {
                take(withdrawn(*event), tick, StoreTicket{}, send);
            }
            return;
        }
        const Wait wait{journals_ && sent_once(item) ? tick : 0, durable ? ticket.number : 0};
        const bool in_line = journals_ && sent_once(item) && !held_.empty();
        if (!in_line && may_leave(wait)) {
            send(item);
        } else {
            held_.push_back({wait, item});
        }
    }

    /// The store has come to `number`.
    template <class Send>
    void stored(std::uint64_t number, Send send) {
        stored_ = number;
        release(send);
    }

    /// The journal holds the inputs up to this tick.
    template <class Send>
    void journaled(Tick tick, Send send) {
        kept_ = tick;
        release(send);
    }

    [[nodiscard]] std::size_t waiting() const { return held_.size(); }

    [[nodiscard]] std::uint64_t refused() const { return refused_; }

  private:
    struct Wait {
        Tick tick = 0;             ///< that the journal must hold; 0: none
        std::uint64_t number = 0;  ///< that the store must have come to; 0: none
    };

    struct Held {
        Wait wait;
        mailbox::OutboxItem item;
    };

    static bool sent_once(const mailbox::OutboxItem& item) {
        return !std::holds_alternative<mailbox::StatePacket>(item) &&
               !std::holds_alternative<mailbox::AuditRecord>(item);
    }

    /// In the place of a refused event: the numbers of those after it stay the same.
    static mailbox::EventOut withdrawn(const mailbox::EventOut& event) {
        mailbox::EventOut out;
        out.event = event.event;
        out.tick = event.tick;
        out.kind = kWithdrawnEvent;
        out.recipients = event.recipients;
        return out;
    }

    [[nodiscard]] bool may_leave(const Wait& wait) const {
        return wait.tick <= kept_ && wait.number <= stored_;
    }

    template <class Send>
    void release(Send send) {
        while (!held_.empty() && may_leave(held_.front().wait)) {
            send(held_.front().item);
            held_.pop_front();
        }
    }

    bool journals_ = false;
    Tick kept_ = 0;
    std::uint64_t stored_ = 0;
    std::deque<Held> held_;
    std::uint64_t refused_ = 0;
};

}  // namespace zoned::app
