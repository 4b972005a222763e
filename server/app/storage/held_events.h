// HeldEvents: durable events wait here until the store has what their tick wrote.
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

/// For one thread.
class HeldEvents {
  public:
    /// Whether the event may leave now. Otherwise it is kept here, or gone where it was refused:
    /// what it tells was not stored, and rules hear so.
    bool may_leave(const mailbox::EventOut& event, const StoreTicket& ticket) {
        if (!event.durable || (!ticket.refused && ticket.number <= durable_)) {
            return true;
        }
        if (ticket.refused) {
            ++refused_;
        } else {
            held_.emplace_back(ticket.number, event);
        }
        return false;
    }

    /// The store has come to `number`: calls `send` with each event that waited for it.
    template <class Send>
    void release(std::uint64_t number, Send send) {
        durable_ = number;
        while (!held_.empty() && held_.front().first <= number) {
            send(held_.front().second);
            held_.pop_front();
        }
    }

    [[nodiscard]] std::size_t waiting() const { return held_.size(); }

    [[nodiscard]] std::uint64_t refused() const { return refused_; }

  private:
    std::uint64_t durable_ = 0;
    std::deque<std::pair<std::uint64_t, mailbox::EventOut>> held_;  // ascending by number
    std::uint64_t refused_ = 0;
};

}  // namespace zoned::app
