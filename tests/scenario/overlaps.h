// Overlaps: all penetrations of a scene at one moment, computed without any engine.
#pragma once

#include "tests/scenario/physics_scenes.h"

#include <span>
#include <vector>

namespace zoned::scenario {

/// Depths in metres, only those greater than zero.
struct Overlaps {
    std::vector<double> pairs;  ///< of two bodies that can move
    std::vector<double> floor;  ///< of such bodies below y = 0
    std::vector<double> fixed;  ///< of such bodies into static ones, the floor among them
};

/// `poses` gives the present pose of each of `bodies`; bodies whose pose is not finite are left
/// out.
Overlaps find_overlaps(std::span<const Body> bodies, std::span<const Pose> poses);

}  // namespace zoned::scenario
