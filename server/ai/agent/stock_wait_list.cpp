#include "server/ai/agent/stock_wait_list.h"

#include "shared/core/rng.h"

#include <algorithm>

namespace zoned::ai {

namespace {

/// Ticks of a long period share places, so that a group takes little memory.
constexpr Tick kMostPhases = 64;

}  // namespace

StockWaitList::WaitGroup::WaitGroup(const WaitKey& key)
    : key_(key),
      phases_(static_cast<std::size_t>(std::min(key.period, kMostPhases))) {
}

std::size_t StockWaitList::HashOfKey::operator()(const WaitKey& key) const {
    const std::uint64_t kind =
        static_cast<std::uint64_t>(key.brain) << 48U | static_cast<std::uint64_t>(key.leaf) << 32U |
        static_cast<std::uint64_t>(key.current_action) << 16U | key.wait.trades;
    const std::uint64_t clauses =
        static_cast<std::uint64_t>(key.wait.clauses) << 32U | key.wait.held;
    return core::mix(core::mix(kind) ^ clauses) ^ static_cast<std::uint64_t>(key.period);
}

void StockWaitList::grow(std::size_t slots) {
    places_.resize(std::max(places_.size(), slots));
}

void StockWaitList::join(Slot slot, EntityId entity, const WaitKey& key) {
    leave(slot);
    const auto [found, fresh] =
        by_key_.try_emplace(key, static_cast<std::uint32_t>(groups_.size()));
    if (fresh) {
        groups_.emplace_back(key);
    }
    WaitGroup& group = groups_[found->second];
    const std::size_t phase =
        static_cast<std::size_t>(static_cast<Tick>(entity.value) % key.period) %
        group.phases_.size();
    std::vector<WaitMember>& members = group.phases_[phase];
    places_[slot] = {found->second,
                     static_cast<std::uint32_t>(phase),
                     static_cast<std::uint32_t>(members.size())};
    members.push_back({entity, slot});
}

void StockWaitList::leave(Slot slot) {
    const WaitPlace place = places_[slot];
    if (place.group == kNone) {
        return;
    }
    std::vector<WaitMember>& members = groups_[place.group].phases_[place.phase];
    members[place.index] = members.back();
    places_[members[place.index].slot].index = place.index;
    members.pop_back();
    places_[slot] = WaitPlace{};
}

}  // namespace zoned::ai
