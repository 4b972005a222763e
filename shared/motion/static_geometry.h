// StaticGeometry: the solid world that never moves, as characters on server and client collide with
// it.
#pragma once

#include "shared/math/aabb.h"
#include "shared/math/types.h"
#include "shared/motion/surface.h"

#include <cstdint>
#include <memory>
#include <optional>
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

/// A surface where it stands, turned about y alone.
struct StaticSurface {
    std::shared_ptr<const Surface> surface;
    Vec3 position = Vec3::Zero();  ///< of its origin, m
    Quat orientation = Quat::Identity();
};

/// A surface in the world: its bounds there, and the way from the world to its own coordinates.
class PlacedSurface {
  public:
    explicit PlacedSurface(const StaticSurface& from);

    [[nodiscard]] const Surface& surface() const { return *surface_; }

    [[nodiscard]] const Aabb& bounds() const { return bounds_; }

    [[nodiscard]] const Vec3& position() const { return position_; }

    [[nodiscard]] Vec3 to_local(const Vec3& p) const { return axes_.transpose() * (p - position_); }

    [[nodiscard]] Vec3 turned_to_local(const Vec3& v) const { return axes_.transpose() * v; }

    [[nodiscard]] Vec3 turned_to_world(const Vec3& v) const { return axes_ * v; }

    [[nodiscard]] Vec3 to_world(const Vec3& p) const { return axes_ * p + position_; }

    /// Height of the topmost front over or under (x, z); none beside it.
    [[nodiscard]] std::optional<float> top_at(float x, float z) const;

  private:
    std::shared_ptr<const Surface> surface_;
    Vec3 position_;
    Mat3 axes_;
    Aabb bounds_;
};

/// Boxes are listed in cells of this size where nobody asks for another, m.
inline constexpr float kStaticCell_m = 16.0F;

/// Oriented boxes in a uniform grid over x and z, and surfaces, above a ground plane
/// y = ground_height.
/// Immutable after construction, so that threads and bots share one copy.
class StaticGeometry {
  public:
    StaticGeometry() = default;
    /// `boxes` in zone-local or world coordinates (the caller's choice, one for all); cell_m > 0.
    StaticGeometry(std::vector<StaticBox> boxes,
                   float ground_height,
                   float cell_m = kStaticCell_m,
                   const std::vector<StaticSurface>& surfaces = {});

    [[nodiscard]] float ground_height() const { return ground_height_; }

    [[nodiscard]] std::span<const StaticBox> boxes() const { return boxes_; }

    [[nodiscard]] const Aabb& box_bounds(std::uint32_t index) const { return bounds_[index]; }

    /// Columns are the box's axes in the coordinates of the world.
    [[nodiscard]] const Mat3& box_axes(std::uint32_t index) const { return axes_[index]; }

    /// Few and large: whoever asks looks at the bounds of each.
    [[nodiscard]] std::span<const PlacedSurface> surfaces() const { return surfaces_; }

    /// Height of the topmost surface over or under (x, z), or of the ground, m. Boxes do not count.
    [[nodiscard]] float floor_at(float x, float z) const;

    /// Calls `visit(index)` once, in ascending order, for each box whose bounds overlap `area`.
    template <class Visit>
    void for_each_near(const Aabb& area, Visit&& visit) const;

  private:
    [[nodiscard]] int cell_of(float coordinate, float origin, int cells) const;

    void index_boxes();

    std::vector<StaticBox> boxes_;
    std::vector<PlacedSurface> surfaces_;
    std::vector<Aabb> bounds_;
    std::vector<Mat3> axes_;
    std::vector<std::uint32_t>
        cell_start_;  // columns of a compressed sparse row layout over the cells
    std::vector<std::uint32_t> cell_items_;
    float ground_height_ = 0.0F;
    float cell_m_ = kStaticCell_m;
    float origin_x_ = 0.0F;
    float origin_z_ = 0.0F;
    int cells_x_ = 0;
    int cells_z_ = 0;
};

}  // namespace zoned::motion

#include "shared/motion/static_geometry_inl.h"
