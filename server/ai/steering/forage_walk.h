// Forage walk: how a creature that forages goes from cell to cell.
#pragma once

#include "server/ai/agent/agent.h"

#include <cstdint>

namespace zoned::ai {

/// What an agent keeps in `corner` while it forages: the direction in which it goes, by eighths of
/// a turn, and these.
inline constexpr std::uint8_t kCarries = 0x08;
inline constexpr std::uint8_t kScouts = 0x10;
inline constexpr std::uint8_t kLost = 0x20;  ///< off the map: it walks straight home
inline constexpr std::uint8_t kBegins = 0x40;

/// So near the middle of a cell counts as there, in cells.
inline constexpr float kAtCell = 0.4F;

/// Whether it goes from cell to cell, straight from one to the next.
inline bool goes_by_cells(const Agent& agent, const BrainState& state) {
    return state.action == ActionKind::kForage && (agent.corner & kLost) == 0;
}

}  // namespace zoned::ai
