// Text of TSPLIB: instances of the travelling salesman problem.
#pragma once

#include "server/ai/ants/distances.h"
#include "shared/core/result.h"

#include <string>
#include <string_view>

namespace zoned::ai::pathfinding {

struct TspInstance {
    std::string name;
    Distances distances;
};

/// Symmetric instances by coordinates (Reinelt, "TSPLIB 95", 1995, sections 1 and 2.1): TYPE TSP,
/// EDGE_WEIGHT_TYPE EUC_2D (rounded to the nearest whole number) or CEIL_2D (rounded up),
/// DIMENSION, NODE_COORD_SECTION with each node from 1 once, in any order. Lines end in LF or CRLF;
/// what stands after EOF is not read. Errors name the line.
core::Result<TspInstance> parse_tsp(std::string_view text);

}  // namespace zoned::ai::pathfinding
