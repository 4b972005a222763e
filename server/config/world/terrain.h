// Terrain: the heights of the static world, on which entities are placed.
#pragma once

#include "server/config/settings.h"
#include "shared/math/aabb.h"
#include "shared/motion/static_geometry.h"

#include <vector>

namespace zoned::config {

/// Ground, static boxes and surfaces, seen from above. World coordinates.
class Terrain {
  public:
    Terrain(std::vector<motion::StaticBox> boxes,
            float ground_height,
            const std::vector<SurfaceSettings>& surfaces = {});

    /// Height of the topmost surface at (x, z): the ground or the upper side of a box or surface,
    /// m.
    [[nodiscard]] float height(float x, float z) const;

    /// True when the topmost thing at (x, z) is a surface from a file, on which little is level.
    [[nodiscard]] bool on_surface(float x, float z) const;

    /// The highest place of a disc around (x, z), from nine sample points, m.
    [[nodiscard]] float highest(float x, float z, float radius) const;

    /// True when no place of a disc around (x, z) is more than `rise` metres (and a centimetre)
    /// above or below its middle.
    [[nodiscard]] bool level(float x, float z, float radius, float rise = 0.0F) const;

    /// True when no static box or surface reaches into `area` and the ground lies below it.
    [[nodiscard]] bool clear(const Aabb& area) const;

  private:
    motion::StaticGeometry geometry_;
};

/// True when an axis-aligned box and an oriented box overlap (separating axis test; Gottschalk,
/// Lin, Manocha, "OBBTree", SIGGRAPH 1996). Touching counts as apart.
bool boxes_overlap(const Aabb& area, const motion::StaticBox& box);

}  // namespace zoned::config
