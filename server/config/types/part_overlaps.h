// Part overlaps: the parts of an assembly that would push each other apart as they are placed.
#pragma once

#include "server/physics/shapes/shape.h"
#include "server/world/entity_type.h"
#include "server/zone/assemblies/assembly_def.h"

#include <cstddef>
#include <span>
#include <vector>

namespace zoned::config {

struct PartOverlap {
    std::size_t a = 0;  ///< parts; a < b
    std::size_t b = 0;
    float depth_m = 0.0F;
};

/// All pairs of parts that overlap by more than 1 cm and may collide: no joint between the two
/// forbids it. Ascending. `solids`: see ZoneSettings.
std::vector<PartOverlap> part_overlaps(const zone::AssemblyDef& assembly,
                                       const world::TypeTable& types,
                                       std::span<const physics::Shape> solids);

}  // namespace zoned::config
