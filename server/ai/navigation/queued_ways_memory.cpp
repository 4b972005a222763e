#include "server/ai/navigation/queued_ways.h"

#include <algorithm>

namespace zoned::ai::navigation {

RequestMemory QueuedWays::memory_of(std::uint32_t number) const {
    const Request& r = requests_[number];
    RequestMemory m;
    m.number = number;
    m.round = r.round;
    m.asker = r.asker;
    m.taken = r.taken;
    m.waiting = r.waiting;
    if (!r.taken) {
        return m;
    }
    m.from = r.from;
    m.to = r.to;
    m.usable = r.usable;
    m.best = r.best;
    m.outcome = r.outcome;
    m.next = r.next;
    m.length_m = r.length_m;
    m.rest_m = r.rest_m;
    m.cost = r.cost;
    m.short_m = r.short_m;
    m.last = r.last;
    const std::span<const Spot> corners = pool_.of(r.corners);
    const std::span<const Hinge> hinges = hinges_.of(r.hinges);
    m.corners.assign(corners.begin(), corners.end());
    m.hinges.assign(hinges.begin(), hinges.end());
    return m;
}

WayMemory QueuedWays::memory() const {
    WayMemory memory;
    memory.free = free_;
    for (std::uint32_t i = 0; i < requests_.size(); ++i) {
        if (requests_[i].taken || requests_[i].waiting) {
            memory.requests.push_back(memory_of(i));
        }
    }
    memory.turns = queue_.turns();
    memory.unled = unled_;
    memory.tables = tables();
    return memory;
}

void QueuedWays::remember(const RequestMemory& m) {
    Request& r = requests_[m.number];
    r.round = m.round;
    r.asker = m.asker;
    r.from = m.from;
    r.to = m.to;
    r.taken = m.taken;
    r.waiting = m.waiting;
    r.usable = m.usable;
    r.best = m.best;
    r.outcome = m.outcome;
    r.next = m.next;
    r.length_m = m.length_m;
    r.rest_m = m.rest_m;
    r.cost = m.cost;
    r.short_m = m.short_m;
    r.last = m.last;
    if (r.taken && r.outcome != Outcome::kFound) {
        watch();
    }
    r.corners = pool_.take(static_cast<std::uint32_t>(m.corners.size()));
    std::copy(m.corners.begin(), m.corners.end(), pool_.of(r.corners).begin());
    r.hinges = hinges_.take(static_cast<std::uint32_t>(m.hinges.size()));
    std::copy(m.hinges.begin(), m.hinges.end(), hinges_.of(r.hinges).begin());
    if (r.taken && r.waiting) {
        ++counts_.waiting;
    }
}

std::string QueuedWays::remember(const WayMemory& memory) {
    WayNumbers numbers = this->numbers();
    numbers.longest_wait_ticks = settings_.longest_wait_ticks;
    std::string wrong = defect_of(memory, numbers);
    if (!wrong.empty()) {
        return wrong;
    }
    for (const RequestMemory& m : memory.requests) {
        if (m.taken && m.usable && m.last == kNoNode) {
            return "way " + std::to_string(m.number) + " ends nowhere";
        }
    }
    requests_.resize(memory.requests.size() + memory.free.size());
    free_ = memory.free;
    free_.reserve(requests_.capacity());
    for (const RequestMemory& m : memory.requests) {
        remember(m);
    }
    queue_.remember(memory.turns);
    unled_ = memory.unled;
    for (const std::uint32_t node : memory.tables) {
        make_table(node);
    }
    return {};
}

}  // namespace zoned::ai::navigation
