#include "server/ai/decision/state_machine/active_states.h"

namespace zoned::ai::state_machine {

void ActiveStates::reset(std::size_t count, std::uint16_t first, Tick now) {
    leaf.assign(count, first);
    pending.assign(count, kNone);
    pending_since.assign(count, 0);
    for (std::size_t level = 0; level < levels; ++level) {
        since[level].assign(count, now);
    }
    for (std::size_t m = 0; m < memories; ++m) {
        memory[m].assign(count, kNone);
    }
}

void ActiveStates::hash(core::StateHash& hash) const {
    hash.add(static_cast<std::uint64_t>(size()));
    for (std::size_t i = 0; i < size(); ++i) {
        hash.add(leaf[i]);
        hash.add(pending[i]);
        hash.add(pending[i] == kNone ? Tick{0} : pending_since[i]);
        for (std::size_t level = 0; level < levels; ++level) {
            hash.add(since[level][i]);
        }
        for (std::size_t m = 0; m < memories; ++m) {
            hash.add(memory[m][i]);
        }
    }
}

}  // namespace zoned::ai::state_machine
