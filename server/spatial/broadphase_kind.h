// Broadphase kind: names the structures over boxes, their settings and the choice by cost.
#pragma once

#include <cstdint>
#include <string_view>

namespace zoned::spatial {

enum class BroadphaseKind : std::uint8_t {
    kAutomatic,     ///< choose_kind decides
    kAllPairs,      ///< every box is looked at, eight at a time
    kGrid,          ///< a stack of uniform grids
    kOctree,        ///< loose
    kQuadtree,      ///< the same over x and z alone
    kSortAndSweep,  ///< sorted along one axis
    kTree,          ///< dynamic tree of boxes
};

struct BroadphaseSettings {
    float cell_m = 4.0F;      ///< grid: cell size of one level, > 0; the others are doublings of it
    int max_depth = 16;       ///< octree, quadtree: levels below the root, 1..30
    int boxes_per_cell = 16;  ///< octree, quadtree: a cell with more of them splits, 1..1000
};

/// The name of a kind as in settings and reports: "automatic", "all_pairs", "grid", "octree",
/// "quadtree", "sort_and_sweep", "tree".
std::string_view name_of(BroadphaseKind kind);

/// The kind that costs least for that many boxes: see the .cpp file for the measurements.
BroadphaseKind choose_kind(std::uint32_t boxes);

}  // namespace zoned::spatial
