#include "server/ai/pathfinding/requests/request_turns.h"

#include <algorithm>
#include <utility>

namespace zoned::ai::pathfinding {

void RequestTurns::push(std::uint32_t request, std::uint32_t asker) {
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

void RequestTurns::take_turn(std::uint32_t asker) {
    line_up(asker, now_);
}

void RequestTurns::line_up(std::uint32_t asker, std::uint32_t turn) {
    requests_[askers_[asker].first].turn = turn;
    ++due_[(turn + wait_) % due_.size()];
    askers_[asker].next = kNone;
    (first_ == kNone ? first_ : askers_[last_].next) = asker;
    last_ = asker;
}

void RequestTurns::pop() {
    const std::uint32_t asker = first_;
    Asker& a = askers_[asker];
    const Turn& r = requests_[a.first];
    --due_[(r.turn + wait_) % due_.size()];
    a.first = r.next;
    first_ = a.next;
    if (a.first != kNone) {
        take_turn(asker);
    }
}

std::uint32_t RequestTurns::required() const {
    std::uint32_t due = 0;
    std::uint32_t most = 0;
    for (std::uint32_t t = 0; t <= wait_; ++t) {
        due += due_[(now_ + t) % due_.size()];
        most = std::max(most, (due + t) / (t + 1));
    }
    return most;
}

std::vector<SavedTurn> RequestTurns::turns() const {
    std::vector<SavedTurn> turns;
    for (std::uint32_t asker = first_; asker != kNone; asker = askers_[asker].next) {
        SavedTurn turn{asker, now_ - requests_[askers_[asker].first].turn, {}};
        for (std::uint32_t r = askers_[asker].first; r != kNone; r = requests_[r].next) {
            turn.requests.push_back(r);
        }
        turns.push_back(std::move(turn));
    }
    return turns;
}

void RequestTurns::load(const std::vector<SavedTurn>& turns) {
    now_ = wait_;  // no asker has waited longer
    for (const SavedTurn& turn : turns) {
        for (const std::uint32_t request : turn.requests) {
            // The first one takes its turn only now, which is put right.
            push(request, turn.asker);
        }
    }
    std::fill(due_.begin(), due_.end(), 0U);
    first_ = kNone;
    last_ = kNone;
    for (const SavedTurn& turn : turns) {
        line_up(turn.asker, now_ - turn.waited_ticks);
    }
}

}  // namespace zoned::ai::pathfinding
