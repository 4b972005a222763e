// ForageDef: where creatures that forage live, and what they look for.
#pragma once

#include "server/ai/pathfinding/pheromones/pheromone_trails.h"

#include <cstdint>
#include <vector>

namespace zoned::ai {

struct ForageDef {
    std::uint16_t nest = 0;             ///< a place
    std::vector<std::uint16_t> food{};  ///< points of interest
    float radius_m = 25.0F;             ///< half the side of the square around the nest, m
    float cell_m = 0.5F;                ///< of the pheromone map
    float explore = 0.15F;  ///< share of the creatures that leave home as scouts, without
                            ///< pheromones to guide them
    pathfinding::TrailSettings trails{};  ///< evaporation: per second
};

}  // namespace zoned::ai
