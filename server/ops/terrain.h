// Terrain: the heights of the static world, to stand entities on.
#pragma once

#include "shared/math/aabb.h"
#include "shared/motion/static_geometry.h"

#include <vector>

namespace zoned::ops {

/// Ground and static boxes, asked from above. World coordinates.
class Terrain {
  public:
    Terrain(std::vector<motion::StaticBox> boxes, float ground_height);

    /// Height of the topmost surface at (x, z): the ground or the upper side of a box, m.
    [[nodiscard]] float height(float x, float z) const;

    /// True when the surface is flat (to a centimetre) under a disc around (x, z).
    [[nodiscard]] bool level(float x, float z, float radius) const;

    /// True when no static box reaches into `area` and the ground lies below it.
    [[nodiscard]] bool clear(const Aabb& area) const;

  private:
    motion::StaticGeometry geometry_;
};

/// True when an axis-aligned box and an oriented box overlap (separating axis test; Gottschalk,
/// Lin, Manocha, "OBBTree", SIGGRAPH 1996). Touching counts as apart.
bool boxes_overlap(const Aabb& area, const motion::StaticBox& box);

}  // namespace zoned::ops
