// StaticGeometry: the static world, its doors and its platforms, with which characters on server
// and client collide.
#pragma once

#include "shared/core/containers/shared_column.h"
#include "shared/math/aabb.h"
#include "shared/math/types.h"
#include "shared/motion/door_courses.h"
#include "shared/motion/doors.h"
#include "shared/motion/ground_surface.h"
#include "shared/motion/platforms/platform_path.h"

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

namespace zoned::motion {

/// A placed surface, turned about y alone.
struct StaticSurface {
    std::shared_ptr<const Surface> surface;
    Vec3 position = Vec3::Zero();  ///< of its origin, m
    Quat orientation = Quat::Identity();
};

/// A surface in the world: its bounds there, and the transform from the world to its own
/// coordinates.
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

/// Default size of the cells in which boxes are listed, m.
inline constexpr float kStaticCell_m = 16.0F;

/// Oriented boxes in a uniform grid over x and z, and surfaces, above a ground plane y =
/// ground_height; doors, which are boxes like these while they are shut; and platforms, whose boxes
/// move. Immutable after construction, so that threads and bots share one copy: each query names
/// its tick. Copies share all columns, so that they cost little. A world without doors or platforms
/// pays nothing for those of others.
class StaticGeometry {
  public:
    StaticGeometry() = default;
    /// `boxes` in zone-local or world coordinates (the caller's choice, one for all); cell_m > 0.
    StaticGeometry(std::vector<StaticBox> boxes,
                   float ground_height,
                   float cell_m = kStaticCell_m,
                   const std::vector<StaticSurface>& surfaces = {},
                   std::vector<Door> doors = {},
                   std::vector<Platform> platforms = {});

    [[nodiscard]] float ground_height() const { return ground_height_; }

    /// The boxes without the doors.
    [[nodiscard]] std::span<const StaticBox> boxes() const { return {boxes_.data(), fixed_}; }

    /// Their boxes are numbered behind boxes().
    [[nodiscard]] std::span<const Door> doors() const { return doors_; }

    /// Whether a door is solid at a tick.
    [[nodiscard]] bool shut_at(std::uint32_t door, Tick tick) const { return !open_at(door, tick); }

    /// A tick after `tick` before which no door turns: of those that rules move, the next one.
    [[nodiscard]] Tick next_turn(Tick tick) const;

    /// The same world, in which courses say how the doors and platforms are that rules move.
    /// Without courses, doors are as their timetable says and platforms stand at their start.
    [[nodiscard]] StaticGeometry with_courses(
        std::shared_ptr<const DoorCourses> doors,
        std::shared_ptr<const PlatformCourses> platforms = nullptr) const;

    /// Boxes that move.
    [[nodiscard]] std::span<const Platform> platforms() const { return platforms_; }

    /// How far along its way a platform is at a tick, in ticks of travel.
    [[nodiscard]] Tick along_at(std::uint32_t platform, Tick tick) const;

    /// The displacement of a platform from its first stop, m.
    [[nodiscard]] Vec3 platform_offset(std::uint32_t platform, Tick tick) const {
        return platforms_[platform].path.offset(along_at(platform, tick));
    }

    /// Its displacement in the tick that ends at `tick`, m.
    [[nodiscard]] Vec3 platform_move(std::uint32_t platform, Tick tick) const {
        return platform_offset(platform, tick) - platform_offset(platform, tick - 1);
    }

    /// Its box where it is at a tick.
    [[nodiscard]] StaticBox platform_box(std::uint32_t platform, Tick tick) const;

    [[nodiscard]] const Mat3& platform_axes(std::uint32_t platform) const {
        return axes_[first_platform() + platform];
    }

    /// Bounds of its box wherever it may be.
    [[nodiscard]] const Aabb& platform_bounds(std::uint32_t platform) const {
        return bounds_[first_platform() + platform];
    }

    /// The same world without its platforms.
    [[nodiscard]] StaticGeometry without_platforms() const;

    /// The same world with only the boxes and surfaces whose bounds overlap `area`, in their order,
    /// and without doors and platforms: for many queries in a small place.
    [[nodiscard]] StaticGeometry around(const Aabb& area) const;

    /// A box, or a door's.
    [[nodiscard]] const StaticBox& box(std::uint32_t index) const { return boxes_[index]; }

    [[nodiscard]] const Aabb& box_bounds(std::uint32_t index) const { return bounds_[index]; }

    /// Columns are the box's axes in the coordinates of the world.
    [[nodiscard]] const Mat3& box_axes(std::uint32_t index) const { return axes_[index]; }

    /// Few and large: a query looks at the bounds of each.
    [[nodiscard]] std::span<const PlacedSurface> surfaces() const { return surfaces_; }

    /// Height of the topmost surface over or under (x, z), or of the ground, m. Boxes do not count.
    [[nodiscard]] float floor_at(float x, float z) const;

    /// Calls `visit(index)` once, in ascending order, for each box whose bounds overlap `area`.
    template <class Visit>
    void for_each_near(const Aabb& area, Visit&& visit) const;

    /// The same for the boxes and the doors that are shut at `tick`.
    template <class Visit>
    void for_each_near(const Aabb& area, Tick tick, Visit&& visit) const;

    /// Calls `visit(number)` for each door whose bounds overlap `area`, in ascending order.
    template <class Visit>
    void for_each_door_near(const Aabb& area, Visit&& visit) const;

    /// Calls `visit(number)` for each platform that may come into `area`, in ascending order.
    template <class Visit>
    void for_each_platform_near(const Aabb& area, Visit&& visit) const;

    /// The same world with the named doors as ordinary boxes, and without the other doors and
    /// platforms. It equals this world while exactly these doors are shut. `shut` is ascending.
    [[nodiscard]] StaticGeometry with_shut(std::span<const std::uint32_t> shut) const;

  private:
    /// Calls `visit(index)` for the boxes from `first` to `end` whose bounds overlap `area`.
    template <class Visit>
    void visit_near(const Aabb& area, std::uint32_t first, std::uint32_t end, Visit&& visit) const;
    /// The cells that `area` touches, or the nearest ones.
    [[nodiscard]] CellRange cells_over(const Aabb& area) const;
    /// The smallest index from `first` on in the lists of these cells; `end`: none below it.
    [[nodiscard]] std::uint32_t next_in(const CellRange& cells,
                                        std::uint32_t first,
                                        std::uint32_t end) const;

    [[nodiscard]] bool open_at(std::uint32_t door, Tick tick) const;

    /// The number of the first platform's box.
    [[nodiscard]] std::uint32_t first_platform() const {
        return static_cast<std::uint32_t>(fixed_ + doors_.size());
    }

    void index_boxes();
    void index_cells();

    core::SharedColumn<StaticBox> boxes_;  // the permanent boxes, the doors', the platforms'
    std::size_t fixed_ = 0;                // number of permanent boxes
    core::SharedColumn<Door> doors_;
    std::shared_ptr<const DoorCourses> courses_;  // null: rules move no door
    core::SharedColumn<Platform> platforms_;
    std::shared_ptr<const PlatformCourses> platform_courses_;  // null: rules move no platform
    core::SharedColumn<PlacedSurface> surfaces_;
    core::SharedColumn<Aabb> bounds_;
    core::SharedColumn<Mat3> axes_;
    core::SharedColumn<std::uint32_t>
        cell_start_;  // columns of a compressed sparse row layout over the cells
    core::SharedColumn<std::uint32_t> cell_items_;
    float ground_height_ = 0.0F;
    float cell_m_ = kStaticCell_m;
    float origin_x_ = 0.0F;
    float origin_z_ = 0.0F;
    int cells_x_ = 0;
    int cells_z_ = 0;
};

}  // namespace zoned::motion

#include "shared/motion/static_geometry_inl.h"
