// Grid reference: checks paths on grids against a plain Dijkstra in doubles and checks each step.
#pragma once

#include "server/ai/pathfinding/grid/grid_map.h"
#include "server/ai/pathfinding/grid/grid_query.h"

#include <initializer_list>
#include <limits>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace zoned::ai::pathfinding {

inline constexpr double kNoPath = std::numeric_limits<double>::infinity();

/// `#` is blocked, anything else passable; rows of the same length.
GridMap map_of(std::initializer_list<std::string_view> rows);

/// Each cell blocked with probability `blocked`, from a seed.
GridMap random_map(int width, int height, float blocked, std::uint64_t seed);

/// Rooms with walls of one cell and a door or two each.
GridMap rooms_map(int width, int height, int room, std::uint64_t seed);

/// Lengths of best paths from `start` to all cells, row by row; kNoPath where there is none.
std::vector<double> all_lengths(const GridMap& map, Cell start);

/// Empty where the corners are a path from `start` to `goal` of that length, step by step legal;
/// else the reason.
std::string wrong_with(const GridMap& map,
                       Cell start,
                       Cell goal,
                       double length,
                       std::span<const Cell> corners);

/// Cells off by less than this are rounding of sums of up to 10,000 steps in doubles.
inline constexpr double kRounding = 1e-8;

}  // namespace zoned::ai::pathfinding
