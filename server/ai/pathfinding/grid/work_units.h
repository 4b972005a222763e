// What the work of GridPathRequests costs in units of about 2 ns: measured over maps of the Moving
// AI benchmark and of zones, and rounded.
#pragma once

#include <cstdint>

namespace zoned::ai::pathfinding {

inline constexpr std::uint64_t kQueryUnits = 600;  ///< a path put together
inline constexpr std::uint64_t kNodeUnits = 100;   ///< a node of a search
inline constexpr std::uint64_t kLookedUnits = 1;  ///< a label, or a cell around a goal out of reach
inline constexpr std::uint64_t kTakeUnits = 40;   ///< a request from the queue, its ends in cells
inline constexpr std::uint64_t kHopUnits = 3;     ///< a step along a field or through an area
inline constexpr std::uint64_t kSightUnits = 2;   ///< a cell that a line of sight looks at
inline constexpr std::uint64_t kCornerUnits = 10;  ///< a corner of a path that is kept
inline constexpr std::uint64_t kFieldUnits = 6;    ///< a cell of a field that is made
inline constexpr std::uint64_t kRegionUnits = 25;  ///< an area of a table to a goal's area
inline constexpr std::uint64_t kMiddleUnits = 4;   ///< an area that is looked at

}  // namespace zoned::ai::pathfinding
