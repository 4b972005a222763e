// Forage walk: how a foraging creature walks from cell to cell.
#pragma once

#include "server/ai/agent/agent.h"

#include <cstdint>

namespace zoned::ai {

/// The contents of Agent::corner while it forages: the direction of its walk, by eighths of a turn,
/// and these flags.
inline constexpr std::uint8_t kCarries = 0x08;
inline constexpr std::uint8_t kScouts = 0x10;
inline constexpr std::uint8_t kLost = 0x20;  ///< off the map: it walks straight home
inline constexpr std::uint8_t kBegins = 0x40;

/// A creature this near to the middle of a cell has reached it, in cells.
inline constexpr float kAtCell = 0.4F;

/// True: the agent walks from cell to cell, straight from one to the next.
inline bool goes_by_cells(const Agent& agent, const BrainState& state) {
    return state.action == ActionKind::kForage && (agent.corner & kLost) == 0;
}

}  // namespace zoned::ai
