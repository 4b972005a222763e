// The names of the product as data: words that were renamed, names that may occur more than once.
#pragma once

#include <array>
#include <span>
#include <string_view>

namespace zoned::lint {

/// A word that must not come back as a part of an identifier. Words have _ between them and are in
/// lower case.
struct RenamedWord {
    std::string_view old;
    std::string_view now;
    std::string_view place;  ///< paths begin with it; empty: everywhere
    /// Identifiers that hold one of these hold the old word in another meaning.
    std::span<const std::string_view> exceptions;
};

inline constexpr std::array<std::string_view, 3> kDirections{"one_way", "each_way", "both_ways"};
inline constexpr std::array<std::string_view, 2> kWaysIn{"ways_in", "both_ways"};

inline constexpr std::array kRenamedWords{
    RenamedWord{"way", "path", "server/ai/pathfinding/", kDirections},
    RenamedWord{"ways", "paths", "", kWaysIn},
    RenamedWord{"make_way", "local avoidance", "", {}},
    RenamedWord{"walk_mesh", "navmesh", "", {}},
    RenamedWord{"goal_field", "flow field", "", {}},
    RenamedWord{"crowded_field", "crowd flow field", "", {}},
    RenamedWord{"half_planes", "ORCA lines", "", {}},
    RenamedWord{"mind", "agent", "", {}},
    RenamedWord{"minds", "agents", "", {}},
    RenamedWord{"wish", "desired velocity", "server/ai/steering/", {}},
    RenamedWord{"deed", "action", "", {}},
    RenamedWord{"doing", "current action", "", {}},
    RenamedWord{"rung", "difficulty level", "", {}},
    RenamedWord{"ladder", "difficulty levels", "", {}},
    RenamedWord{"onlooker", "perceiver", "", {}},
    RenamedWord{"wavering", "state flapping", "", {}},
    RenamedWord{"bargain", "trade result", "", {}},
    RenamedWord{"stock_waits", "stock wait list", "", {}},
    RenamedWord{"coarse_cells", "offscreen grid", "", {}},
    RenamedWord{"encounters", "proximity schedule", "", {}},
    RenamedWord{"rouse", "wake", "", {}},
    RenamedWord{"conceal", "visibility filter", "", {}},
    RenamedWord{"news", "updates", "", {}},
    RenamedWord{"hearers", "recipients", "", {}},
    RenamedWord{"kept_grid", "incremental grid", "", {}},
    RenamedWord{"slow_state", "shared environment", "", {}},
};

/// Names of headers that may occur more than once.
inline constexpr std::array<std::string_view, 0> kRepeatedHeaders{};

/// Names of types that may occur more than once.
inline constexpr std::array<std::string_view, 0> kRepeatedTypes{};

}  // namespace zoned::lint
