// StaticGeometry: the solid world that never moves, as characters on server and client collide with
// it.
#pragma once

#include "shared/math/aabb.h"
#include "shared/math/types.h"

#include <cstdint>
#include <span>
#include <vector>

namespace zoned::motion {

/// A static oriented box: wall, floor slab or ramp.
struct StaticBox {
    Vec3 centre = Vec3::Zero();        ///< m
    Vec3 half_extents = Vec3::Ones();  ///< m, each > 0
    Quat orientation = Quat::Identity();
    float friction = 0.6F;
    float restitution = 0.0F;
};

/// Oriented boxes in a uniform grid over x and z, above a ground plane y = ground_height.
/// Immutable after construction, so that threads and bots share one copy.
class StaticGeometry {
  public:
    StaticGeometry() = default;
    /// `boxes` in zone-local or world coordinates (the caller's choice, one for all); cell_m > 0.
    StaticGeometry(std::vector<StaticBox> boxes, float ground_height, float cell_m = 16.0F);

    [[nodiscard]] float ground_height() const { return ground_height_; }

    [[nodiscard]] std::span<const StaticBox> boxes() const { return boxes_; }

    [[nodiscard]] const Aabb& box_bounds(std::uint32_t index) const { return bounds_[index]; }

    /// Columns are the box's axes in the coordinates of the world.
    [[nodiscard]] const Mat3& box_axes(std::uint32_t index) const { return axes_[index]; }

    /// Calls `visit(index)` once, in ascending order, for each box whose bounds overlap `area`.
    template <class Visit>
    void for_each_near(const Aabb& area, Visit&& visit) const;

  private:
    [[nodiscard]] int cell_of(float coordinate, float origin, int cells) const;

    std::vector<StaticBox> boxes_;
    std::vector<Aabb> bounds_;
    std::vector<Mat3> axes_;
    std::vector<std::uint32_t>
        cell_start_;  // columns of a compressed sparse row layout over the cells
    std::vector<std::uint32_t> cell_items_;
    float ground_height_ = 0.0F;
    float cell_m_ = 16.0F;
    float origin_x_ = 0.0F;
    float origin_z_ = 0.0F;
    int cells_x_ = 0;
    int cells_z_ = 0;
};

}  // namespace zoned::motion

#include "shared/motion/static_geometry_inl.h"
