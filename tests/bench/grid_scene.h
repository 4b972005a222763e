// GridScene: a map of the Moving AI benchmark with its queries and the lengths of the best paths.
#pragma once

#include "tests/scenario/grid_text.h"

#include <optional>
#include <string>
#include <vector>

namespace zoned::bench {

struct GridScene {
    std::string name;
    ai::pathfinding::GridMap map;
    std::vector<scenario::GridInstance> instances;
};

/// Reads movingai/`name`.map and its scenario from the public data, or else from tests/conformance.
/// Returns nothing where the files are missing or can't be read (`why` gives the reason). Takes
/// every `step`-th instance.
std::optional<GridScene> read_grid_scene(const std::string& name,
                                         std::size_t step,
                                         std::string& why);

/// Lengths in the scenarios have two decimals on some maps. A path that differs by more is not a
/// best path.
inline constexpr double kLengthTolerance = 0.011;

}  // namespace zoned::bench
