// ActiveState: an agent's states in its state machine, their entry times, its pending transition.
#pragma once

#include "server/ai/decision/state_machine/state_machine_def.h"
#include "shared/core/ids.h"

#include <array>
#include <cstdint>

namespace zoned::ai::state_machine {

/// No transition, or no memory.
inline constexpr std::uint16_t kNone = 0xFFFF;

/// Part of snapshots, handoffs and hashes.
struct ActiveState {
    /// Starts in the first state, which is leaf 0 of every state machine, entered at `now`.
    explicit ActiveState(Tick now = 0) {
        since.fill(now);
        memory.fill(kNone);
    }

    std::uint16_t leaf = 0;                          ///< the innermost state
    std::uint16_t pending = kNone;                   ///< transition that is being held, or kNone
    Tick pending_since = 0;                          ///< start of its hold, if there is one
    std::array<Tick, kMaxLevels> since;              ///< by level: when that state was entered
    std::array<std::uint16_t, kMaxMemories> memory;  ///< the state to return to
};

/// StateChange: a transition that fired.
struct StateChange {
    std::uint32_t agent = 0;
    std::uint16_t from = 0;  ///< innermost states
    std::uint16_t to = 0;
    std::uint16_t transition = 0;  ///< numbered through the state machine
};

}  // namespace zoned::ai::state_machine
