// BoxColumn: the part of a vertical line that lies within a static box.
#pragma once

#include "shared/motion/static_geometry.h"

#include <algorithm>
#include <cmath>
#include <optional>

namespace zoned::ai::pathfinding {

struct BoxColumn {
    float bottom = 0.0F;  ///< m
    float top = 0.0F;
    float up = 1.0F;  ///< vertical part of the normal of the face at the top
};

/// Nothing where the line over (x, z) passes beside the box. Source for the line's part between
/// each pair of faces: Ericson, Real-Time Collision Detection, 5.3.3.
inline std::optional<BoxColumn> column_of_box(const motion::StaticGeometry& world,
                                              std::uint32_t index,
                                              float x,
                                              float z) {
    const motion::StaticBox& box = world.boxes()[index];
    const Mat3& axes = world.box_axes(index);
    BoxColumn column{world.box_bounds(index).lower.y(), world.box_bounds(index).upper.y(), 1.0F};
    const Vec3 offset(x - box.centre.x(), -box.centre.y(), z - box.centre.z());
    for (int axis = 0; axis < 3; ++axis) {
        const float at = axes.col(axis).dot(offset);
        const float slope = axes(1, axis);
        const float half = box.half_extents[axis];
        if (std::abs(slope) < 1e-6F) {
            if (std::abs(at) > half) {
                return std::nullopt;
            }
            continue;
        }
        const float a = (-half - at) / slope;
        const float b = (half - at) / slope;
        column.bottom = std::max(column.bottom, std::min(a, b));
        if (std::max(a, b) < column.top) {
            column.top = std::max(a, b);
            column.up = std::abs(slope);
        }
    }
    return column.bottom <= column.top ? std::optional<BoxColumn>(column) : std::nullopt;
}

}  // namespace zoned::ai::pathfinding
