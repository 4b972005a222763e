#include "client-sim/link/event_inbox.h"

#include <algorithm>

namespace zoned::link {

bool EventInbox::known_id(std::uint64_t event_id) {
    if (event_id == 0) {
        return false;
    }
    if (std::ranges::find(recent_ids_, event_id) != recent_ids_.end()) {
        return true;
    }
    if (recent_ids_.size() < kRecent) {
        recent_ids_.push_back(event_id);
    } else {
        recent_ids_[recent_next_] = event_id;
        recent_next_ = (recent_next_ + 1) % kRecent;
    }
    return false;
}

bool EventInbox::accept(std::uint64_t number, std::uint64_t event_id) {
    if (number <= newest_) {
        if (missing_.erase(number) == 0) {
            ++duplicated_;
            return false;
        }
        // Heard after all, but later than a newer one: delivered, and counted as out of order.
        ++out_of_order_;
    } else {
        // Bounded: a hostile number must not fill the memory, its hole is counted as a sum.
        for (std::uint64_t hole = newest_ + 1; hole < number; ++hole) {
            if (missing_.size() >= kMaxMissing) {
                missing_uncounted_ += number - hole;
                break;
            }
            missing_.insert(hole);
        }
        newest_ = number;
    }
    if (known_id(event_id)) {
        ++duplicated_;
        return false;
    }
    ++delivered_;
    return true;
}

void EventInbox::restart() {
    numbered_before_ += newest_;
    missing_uncounted_ += missing_.size();
    missing_.clear();
    newest_ = 0;
    recent_ids_.clear();
    recent_next_ = 0;
}

}  // namespace zoned::link
