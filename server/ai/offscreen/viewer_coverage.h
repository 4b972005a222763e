// ViewerCoverage: where in a zone a viewer could see an entity.
#pragma once

#include "shared/math/types.h"

#include <cstdint>
#include <span>
#include <vector>

namespace zoned::ai {

/// Squares around viewers. One look-up answers for a position, however many viewers there are. It
/// is a bitmap beside the grids of server/spatial, which would answer with the viewers themselves.
class ViewerCoverage {
  public:
    /// Covers at least every position within `radius_m` (> 0) of a viewer (x, z, m), and at most a
    /// cell's diagonal more. Deterministic; allocates only where the area grows.
    void build(std::span<const Vec2> viewers, float radius_m);

    [[nodiscard]] bool covers(const Vec2& at) const {
        const float x = (at.x() - origin_.x()) * per_m_;
        const float z = (at.y() - origin_.y()) * per_m_;
        // Written so that NaN is not covered.
        return x >= 0.0F && z >= 0.0F && x < static_cast<float>(columns_) &&
               z < static_cast<float>(rows_) &&
               cells_[static_cast<std::size_t>(z) * columns_ + static_cast<std::size_t>(x)] != 0;
    }

  private:
    void mark(const Vec2& viewer, float radius_m);

    Vec2 origin_ = Vec2::Zero();
    float cell_m_ = 1.0F;
    float per_m_ = 1.0F;
    std::size_t columns_ = 0;
    std::size_t rows_ = 0;
    std::vector<std::uint8_t> cells_;
};

}  // namespace zoned::ai
