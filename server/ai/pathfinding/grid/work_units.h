// Work units: the costs of GridPathRequests' work in units of about 2 ns.
// They were measured on maps of the Moving AI benchmark and of zones, and rounded.
#pragma once

#include <cstdint>

namespace zoned::ai::pathfinding {

inline constexpr std::uint64_t kQueryUnits = 600;  ///< a path put together
inline constexpr std::uint64_t kNodeUnits = 100;   ///< a node of a search
inline constexpr std::uint64_t kLookedUnits = 1;   ///< a label, or a cell around a goal that is out
                                                   ///< of reach
inline constexpr std::uint64_t kTakeUnits = 40;    ///< taking a request from the queue and finding
                                                   ///< its ends in cells
inline constexpr std::uint64_t kHopUnits = 3;      ///< a step along a field or through a region
inline constexpr std::uint64_t kSightUnits = 2;    ///< a cell that a line of sight tests
inline constexpr std::uint64_t kCornerUnits = 10;  ///< a corner of a path that is kept
inline constexpr std::uint64_t kFieldUnits = 6;    ///< a cell of a field that is made
inline constexpr std::uint64_t kRegionUnits = 25;  ///< a region in a table to a goal's region
inline constexpr std::uint64_t kIndexUnits = 50;   ///< a place of a map that gets an index
inline constexpr std::uint64_t kMiddleUnits = 4;   ///< a region that is looked at

}  // namespace zoned::ai::pathfinding
