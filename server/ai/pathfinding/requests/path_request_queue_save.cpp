#include "server/ai/pathfinding/requests/path_request_queue.h"

#include <algorithm>

namespace zoned::ai::pathfinding {

SavedRequest PathRequestQueue::saved_request(std::uint32_t number) const {
    const PathRequestEntry& r = requests_[number];
    SavedRequest m;
    m.number = number;
    if (!r.taken) {  // of no use but for its turn
        m.round = r.round;
        m.asker = r.asker;
        m.waiting = r.waiting;
        return m;
    }
    static_cast<RequestState&>(m) = r;
    const std::span<const Spot> corners = pool_.of(r.corners);
    const std::span<const Hinge> hinges = hinges_.of(r.hinges);
    m.corners.assign(corners.begin(), corners.end());
    m.hinges.assign(hinges.begin(), hinges.end());
    return m;
}

SavedPaths PathRequestQueue::save() const {
    SavedPaths memory;
    memory.free = free_;
    for (const std::uint32_t number : free_) {
        memory.free_rounds.push_back(requests_[number].round);
    }
    for (std::uint32_t i = 0; i < requests_.size(); ++i) {
        if (requests_[i].taken || requests_[i].waiting) {
            memory.requests.push_back(saved_request(i));
        }
    }
    memory.turns = queue_.turns();
    memory.unled = unled_;
    for (const std::uint32_t node : tables()) {
        memory.tables.push_back({node, 0});
    }
    return memory;
}

void PathRequestQueue::load(const SavedRequest& m) {
    PathRequestEntry& r = requests_[m.number];
    static_cast<RequestState&>(r) = m;
    r.corners = pool_.take(static_cast<std::uint32_t>(m.corners.size()));
    std::copy(m.corners.begin(), m.corners.end(), pool_.of(r.corners).begin());
    r.hinges = hinges_.take(static_cast<std::uint32_t>(m.hinges.size()));
    std::copy(m.hinges.begin(), m.hinges.end(), hinges_.of(r.hinges).begin());
    if (r.taken && r.waiting) {
        ++counts_.waiting;
    }
}

std::string PathRequestQueue::load(const SavedPaths& memory) {
    MapNumbers numbers = this->numbers();
    numbers.longest_wait_ticks = settings_.longest_wait_ticks;
    std::string wrong = defect_of(memory, numbers);
    if (!wrong.empty()) {
        return wrong;
    }
    for (const SavedRequest& m : memory.requests) {
        if (m.taken && m.usable && m.last == kNoNode) {
            return "path " + std::to_string(m.number) + " ends nowhere";
        }
    }
    requests_.resize(memory.requests.size() + memory.free.size());
    free_ = memory.free;
    free_.reserve(requests_.capacity());
    for (std::size_t i = 0; i < free_.size(); ++i) {
        requests_[free_[i]].round = memory.free_rounds[i];
    }
    for (const SavedRequest& m : memory.requests) {
        load(m);
    }
    queue_.load(memory.turns);
    unled_ = memory.unled;
    for (const auto& [node, used] : memory.tables) {
        make_table(node);
    }
    return {};
}

}  // namespace zoned::ai::pathfinding
