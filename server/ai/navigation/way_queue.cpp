#include "server/ai/navigation/way_queue.h"

#include <algorithm>

namespace zoned::ai::navigation {

void WayQueue::push(std::uint32_t request, std::uint32_t asker) {
    if (request >= requests_.size()) {
        requests_.resize(request + std::size_t{1});
    }
    if (asker >= askers_.size()) {
        askers_.resize(asker + std::size_t{1});
    }
    requests_[request].next = kNone;
    Asker& a = askers_[asker];
    if (a.first != kNone) {
        requests_[a.last].next = request;
        a.last = request;
        return;
    }
    a.first = request;
    a.last = request;
    take_turn(asker);
}

void WayQueue::take_turn(std::uint32_t asker) {
    requests_[askers_[asker].first].turn = now_;
    ++due_[(now_ + wait_) % due_.size()];
    askers_[asker].next = kNone;
    (first_ == kNone ? first_ : askers_[last_].next) = asker;
    last_ = asker;
}

void WayQueue::pop() {
    const std::uint32_t asker = first_;
    Asker& a = askers_[asker];
    const Request& r = requests_[a.first];
    --due_[(r.turn + wait_) % due_.size()];
    a.first = r.next;
    first_ = a.next;
    if (a.first != kNone) {
        take_turn(asker);
    }
}

std::uint32_t WayQueue::required() const {
    std::uint32_t due = 0;
    std::uint32_t most = 0;
    for (std::uint32_t t = 0; t <= wait_; ++t) {
        due += due_[(now_ + t) % due_.size()];
        most = std::max(most, (due + t) / (t + 1));
    }
    return most;
}

}  // namespace zoned::ai::navigation
