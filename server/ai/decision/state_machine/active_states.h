// ActiveStates: each agent's active state, its entry time and its pending transition, in columns.
#pragma once

#include "server/ai/decision/state_machine/state_machine_def.h"
#include "shared/core/ids.h"
#include "shared/core/state_hash.h"

#include <array>
#include <cstdint>
#include <vector>

namespace zoned::ai::state_machine {

/// No transition, or no memory.
inline constexpr std::uint16_t kNone = 0xFFFF;

/// The memory of agents that share a state machine; part of snapshots, handoffs and hashes. Columns
/// by agent. A state machine written as code uses one level and no memory.
struct ActiveStates {
    explicit ActiveStates(std::size_t levels_of = 1, std::size_t memories_of = 0)
        : levels(levels_of),
          memories(memories_of) {}

    std::size_t levels;
    std::size_t memories;
    std::vector<std::uint16_t> leaf;                  ///< the innermost state
    std::vector<std::uint16_t> pending;               ///< transition that is being held, or kNone
    std::vector<Tick> pending_since;                  ///< start of the pending transition's hold,
                                                      ///< if there is one
    std::array<std::vector<Tick>, kMaxLevels> since;  ///< by level: when that state was entered
    std::array<std::vector<std::uint16_t>, kMaxMemories> memory;  ///< the state to return to

    [[nodiscard]] std::size_t size() const { return leaf.size(); }

    /// Puts `count` agents in state `first`, entered at `now`; previous content is lost.
    void reset(std::size_t count, std::uint16_t first, Tick now);

    void hash(core::StateHash& hash) const;
};

/// The same for one agent, as columns of one element.
struct ActiveState {
    /// Starts in the first state, which is leaf 0 of every state machine, entered at `now`.
    explicit ActiveState(Tick now = 0) {
        for (auto& entered : since) {
            entered[0] = now;
        }
        for (auto& remembered : memory) {
            remembered[0] = kNone;
        }
    }

    std::array<std::uint16_t, 1> leaf{};
    std::array<std::uint16_t, 1> pending{kNone};
    std::array<Tick, 1> pending_since{};
    std::array<std::array<Tick, 1>, kMaxLevels> since{};
    std::array<std::array<std::uint16_t, 1>, kMaxMemories> memory;

    /// The innermost state.
    [[nodiscard]] std::uint16_t state() const { return leaf[0]; }
};

/// StateChange: a transition that fired.
struct StateChange {
    std::uint32_t agent = 0;
    std::uint16_t from = 0;  ///< innermost states
    std::uint16_t to = 0;
    std::uint16_t transition = 0;  ///< numbered through the state machine
};

}  // namespace zoned::ai::state_machine
