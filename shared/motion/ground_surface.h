// Surface: static triangles or heights in their own coordinates, on which characters on server and
// client walk.
#pragma once

#include "shared/math/aabb.h"
#include "shared/math/segment_triangle.h"
#include "shared/math/types.h"

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

namespace zoned::motion {

/// Heights over a regular grid whose middle is the origin: sample (i, k) lies at
/// x = (i - (columns - 1) / 2) spacing_x, z = (k - (rows - 1) / 2) spacing_z; the diagonal of each
/// cell runs from its lowest x and z to its highest.
struct HeightGrid {
    std::uint32_t columns = 0;  ///< samples along x, >= 2
    std::uint32_t rows = 0;     ///< samples along z, >= 2
    float spacing_x = 1.0F;     ///< m, > 0
    float spacing_z = 1.0F;
    float thickness = 0.0F;          ///< depth of the solid below the lowest sample, m
    std::span<const float> heights;  ///< m, row by row
};

/// Triangles, counter-clockwise seen from the front, each with an area.
struct TriangleList {
    std::span<const Vec3> vertices;
    std::span<const std::array<std::uint32_t, 3>> corners;
};

/// Cells of a grid over x and z.
struct CellRange {
    int x0, x1, z0, z1;  ///< last ones included
};

/// Solid behind its triangles, a height grid below them. Refers to tables that `owner` keeps, so
/// that physics and movement, and all zones, share one copy. Immutable.
class Surface {
  public:
    Surface(const HeightGrid& grid, std::shared_ptr<const void> owner);
    Surface(const TriangleList& mesh, std::shared_ptr<const void> owner);

    [[nodiscard]] const Aabb& box() const { return box_; }

    [[nodiscard]] bool is_grid() const { return grid_.columns != 0; }

    [[nodiscard]] const HeightGrid& grid() const { return grid_; }

    [[nodiscard]] const TriangleList& mesh() const { return mesh_; }

    /// Calls `visit(triangle)` once for each triangle whose bounds overlap `area`, always in the
    /// same order.
    template <class Visit>
    void for_each_near(const Aabb& area, Visit&& visit) const;

    /// Height of the topmost front over or under (x, z), m; none beside the surface.
    [[nodiscard]] std::optional<float> top_at(float x, float z) const;

    /// Whether a point lies inside the solid: the nearest triangle above it shows its back, and a
    /// grid is thick enough.
    [[nodiscard]] bool behind(const Vec3& p) const;

  private:
    [[nodiscard]] CellRange cells_over(const Aabb& area) const;
    [[nodiscard]] FacedTriangle grid_triangle(int i, int k, int half) const;
    [[nodiscard]] FacedTriangle mesh_triangle(std::uint32_t index) const;
    void index_mesh();

    std::shared_ptr<const void> owner_;
    HeightGrid grid_;
    TriangleList mesh_;
    Aabb box_;
    // CellRange over x and z: a grid's own, or those in which a mesh's triangles are listed.
    Vec3 cell_ = Vec3::Ones();  ///< sizes along x and z, m
    int cells_x_ = 0;
    int cells_z_ = 0;
    std::vector<std::uint32_t> cell_start_;  ///< compressed sparse rows over the cells
    std::vector<std::uint32_t> cell_items_;
};

}  // namespace zoned::motion

#include "shared/motion/ground_surface_inl.h"
