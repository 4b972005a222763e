// AskedTicks: the ticks whose requests the store has not carried out yet.
#pragma once

#include "server/app/storage/held_output.h"
#include "shared/core/ids.h"

#include <cstdint>
#include <deque>
#include <mutex>
#include <utility>

namespace zoned::app {

/// From any thread.
class AskedTicks {
  public:
    /// False: the store refused the requests, or there is none; that is an end as well.
    bool submitted(Tick tick, const StoreTicket& ticket) {
        const std::lock_guard lock(mutex_);
        const bool waits = !ticket.refused && ticket.number != 0;
        if (waits) {
            waiting_.emplace_back(ticket.number, tick);
        }
        return waits;
    }

    /// Calls `kept(tick)` for each tick whose requests the store has carried out with this number.
    /// One whose receipt comes late is told with the next.
    template <class Kept>
    void stored(std::uint64_t number, Kept kept) {
        const std::lock_guard lock(mutex_);
        while (!waiting_.empty() && waiting_.front().first <= number) {
            kept(waiting_.front().second);
            waiting_.pop_front();
        }
    }

  private:
    std::mutex mutex_;
    std::deque<std::pair<std::uint64_t, Tick>> waiting_;  // ascending
};

}  // namespace zoned::app
