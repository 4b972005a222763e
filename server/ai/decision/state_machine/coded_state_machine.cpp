// build: hot loops
#include "server/ai/decision/state_machine/coded_state_machine.h"

namespace zoned::ai::state_machine {

void CodedColumns::change(std::size_t agent, std::uint16_t to, std::uint16_t transition) const {
    changes.push_back({static_cast<std::uint32_t>(agent), leaf[agent], to, transition});
    leaf[agent] = to;
    since[agent] = now;
    pending[agent] = kNone;
}

bool CodedColumns::held(std::size_t agent, std::uint16_t transition, Tick hold) const {
    if (pending[agent] != transition) {
        pending[agent] = transition;
        pending_since[agent] = now;
        return false;
    }
    return now - pending_since[agent] >= hold;
}

bool group_by_state(const std::uint16_t* leaf,
                    std::size_t count,
                    std::array<std::uint8_t, kCodedBlock>& order) {
    std::uint16_t differ = 0;
    for (std::size_t i = 0; i < count; ++i) {
        differ = static_cast<std::uint16_t>(differ | (leaf[i] ^ leaf[0]));
    }
    if (differ == 0) {
        return false;
    }
    // States that share their last six bits share a place: that costs time alone.
    constexpr std::size_t kPlaces = 64;
    std::array<std::uint16_t, kPlaces + 1> at{};
    for (std::size_t i = 0; i < count; ++i) {
        ++at[leaf[i] % kPlaces + 1];
    }
    for (std::size_t place = 1; place < kPlaces; ++place) {
        at[place] = static_cast<std::uint16_t>(at[place] + at[place - 1]);
    }
    for (std::size_t i = 0; i < count; ++i) {
        order[at[leaf[i] % kPlaces]++] = static_cast<std::uint8_t>(i);
    }
    return true;
}

void sort_changes(std::vector<StateChange>& changes, std::size_t first) {
    std::sort(changes.begin() + static_cast<std::ptrdiff_t>(first),
              changes.end(),
              [](const StateChange& a, const StateChange& b) { return a.agent < b.agent; });
}

}  // namespace zoned::ai::state_machine
