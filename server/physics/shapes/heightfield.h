// Heightfield: a static surface of heights over a regular grid.
#pragma once

#include "server/physics/shapes/shape.h"
#include "server/physics/shapes/surface.h"
#include "shared/core/result.h"
#include "shared/math/aabb.h"

#include <memory>
#include <span>
#include <vector>

namespace zoned::physics {

inline constexpr std::uint32_t kMaxFieldSamples = 1U << 14;  ///< along one side

/// Immutable. Sample (i, k) of the grid lies at x = (i - (columns - 1) / 2) spacing_x, z = (k -
/// (rows - 1) / 2) spacing_z, so that the middle of the grid is the body's origin; y is up. The
/// diagonal of each cell runs from its lowest x and z to its highest. Solid below, down to
/// `thickness` under its lowest sample: a body with its centre there is pushed up out of it.
class Heightfield final : public Geometry {
  public:
    struct HeightfieldTables {
        std::uint32_t columns = 0;  ///< samples along x
        std::uint32_t rows = 0;     ///< samples along z
        float spacing_x = 1.0F;     ///< m
        float spacing_z = 1.0F;
        std::vector<float> heights;  ///< m, row by row
        float lowest = 0.0F;
        float highest = 0.0F;
        float thickness = 0.0F;
    };

    explicit Heightfield(HeightfieldTables tables)
        : Geometry(ShapeKind::kHeightfield),
          t_(std::move(tables)) {}

    [[nodiscard]] Aabb box() const;

    /// HeightfieldCells (i, k) with lower.i <= i < upper.i and so on, whose columns overlap a box.
    struct HeightfieldCells {
        std::uint32_t first_i = 0, last_i = 0, first_k = 0, last_k = 0;  // last is one beyond
    };

    [[nodiscard]] HeightfieldCells cells_over(const Aabb& area) const;

    [[nodiscard]] float height(std::uint32_t i, std::uint32_t k) const {
        return t_.heights[static_cast<std::size_t>(k) * t_.columns + i];
    }

    [[nodiscard]] Vec3 sample(std::uint32_t i, std::uint32_t k) const;

    /// Of cell (i, k): half 0 lies towards +x, half 1 towards +z. Its id is 2 (k (columns - 1) + i)
    /// + half.
    [[nodiscard]] Triangle triangle(std::uint32_t i, std::uint32_t k, std::uint32_t half) const;

    /// The same without the bends.
    [[nodiscard]] Triangle bare_triangle(std::uint32_t i,
                                         std::uint32_t k,
                                         std::uint32_t half) const;

    /// The triangle over or under a point; false when the point is beside the field.
    [[nodiscard]] bool triangle_at(const Vec3& p, Triangle& out) const;

    [[nodiscard]] const HeightfieldTables& tables() const { return t_; }

  private:
    HeightfieldTables t_;
};

/// The field of a shape of kind kHeightfield.
inline const Heightfield& field_of(const Shape& shape) {
    return static_cast<const Heightfield&>(*shape.geometry);
}

struct FieldOptions {
    std::uint32_t columns = 0;  ///< samples along x, 2..kMaxFieldSamples
    std::uint32_t rows = 0;     ///< samples along z
    float spacing_x = 1.0F;     ///< m between samples
    float spacing_z = 1.0F;
    float scale = 1.0F;      ///< m of height per unit of a sample
    float offset = 0.0F;     ///< m, added to each height
    float thickness = 1.0F;  ///< m
};

/// columns x rows samples, row by row (x runs fastest). Fails with the reason when the number of
/// samples does not fit, one is not finite or out of range, or a size is out of range.
core::Result<std::shared_ptr<const Heightfield>> build_heightfield(std::span<const float> samples,
                                                                   const FieldOptions& options);

}  // namespace zoned::physics
