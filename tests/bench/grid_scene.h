// GridScene: a map of the Moving AI benchmark with its queries and the lengths of best ways.
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

/// movingai/`name`.map and its scenario from the directory of the public data, or else from
/// tests/conformance; nothing where they
/// are not there or can't be read (`why` says so). Of the instances every `step`-th.
std::optional<GridScene> read_grid_scene(const std::string& name,
                                         std::size_t step,
                                         std::string& why);

/// All of a file; empty where it can't be read.
std::string text_of_file(const std::string& file);

/// Lengths in the scenarios have two decimals on some maps: none that is off by more is a best way.
inline constexpr double kLengthTolerance = 0.011;

}  // namespace zoned::bench
