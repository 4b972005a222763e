#include "server/ai/pathfinding/path_service.h"

#include <algorithm>

namespace zoned::ai {

namespace {

constexpr Slot kNobody = ~Slot{0};

}  // namespace

SavedPathService PathService::save() const {
    SavedPathService memory;
    for (const Asked& asked : asked_) {
        if (asked.size != kNoSize) {
            memory.asked.push_back(asked);
        }
    }
    std::sort(memory.asked.begin(), memory.asked.end(), [](const auto& a, const auto& b) {
        return a.entity < b.entity;
    });
    for (const Size& size : sizes_) {
        memory.sizes.push_back(size.map->save());
    }
    return memory;
}

std::string PathService::load(const SavedPathService& memory,
                              const std::function<std::optional<Slot>(EntityId)>& slot_of) {
    if (memory.sizes.size() != sizes_.size()) {
        return "paths of " + std::to_string(memory.sizes.size()) + " sizes of characters, not " +
               std::to_string(sizes_.size());
    }
    for (std::size_t s = 0; s < sizes_.size(); ++s) {
        std::string wrong = sizes_[s].map->load(memory.sizes[s]);
        if (!wrong.empty()) {
            return wrong;
        }
        sizes_[s].agent_of_request.assign(
            memory.sizes[s].requests.size() + memory.sizes[s].free.size(), kNobody);
    }
    for (const SavedPathService::Asked& asked : memory.asked) {
        const std::string name = "the path of entity " + std::to_string(asked.entity.value) + " ";
        const std::optional<Slot> found = slot_of(asked.entity);
        if (!found || asked.size >= sizes_.size()) {
            return name + "is that of no agent";
        }
        const Slot slot = *found;
        Size& size = sizes_[asked.size];
        if (asked.ticket.slot >= size.agent_of_request.size() || !size.map->knows(asked.ticket) ||
            size.agent_of_request[asked.ticket.slot] != kNobody || has(slot, asked.entity)) {
            return name + "is none, or another's";
        }
        size.agent_of_request[asked.ticket.slot] = slot;
        asked_.resize(std::max<std::size_t>(asked_.size(), slot + std::size_t{1}));
        asked_[slot] = asked;
        if (asked.rough) {
            note_rough(slot);
        }
    }
    std::size_t taken = 0;
    for (const pathfinding::SavedPaths& map : memory.sizes) {
        taken += static_cast<std::size_t>(std::count_if(
            map.requests.begin(), map.requests.end(), [](const auto& r) { return r.taken; }));
    }
    return taken == memory.asked.size() ? "" : "a path is that of nobody";
}

}  // namespace zoned::ai
