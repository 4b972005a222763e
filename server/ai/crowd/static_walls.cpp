#include "server/ai/crowd/static_walls.h"

#include "shared/core/assert.h"

#include <array>
#include <cmath>
#include <utility>

namespace zoned::ai::steering {

namespace {

/// Boxes whose top is lower than this above the ground are no walls, m. Boxes that begin above a
/// head are none either.
constexpr float kLowWall = 0.35F;
constexpr float kHead = 1.0F;

bool is_wall(const motion::StaticGeometry& statics, std::uint32_t i) {
    const motion::StaticBox& box = statics.boxes()[i];
    const float floor = statics.floor_at(box.centre.x(), box.centre.z());
    const bool upright = std::abs(statics.box_axes(i)(1, 1)) > 0.999F;
    const bool low = box.centre.y() + box.half_extents.y() < floor + kLowWall;
    const bool high = box.centre.y() - box.half_extents.y() > floor + kHead;
    return upright && !low && !high;
}

}  // namespace

Walls walls_of(const motion::StaticGeometry& statics, float cell_m) {
    std::vector<Wall> sides;
    for (std::uint32_t i = 0; i < statics.boxes().size(); ++i) {
        if (!is_wall(statics, i)) {
            continue;
        }
        const motion::StaticBox& box = statics.boxes()[i];
        const Vec3 x = statics.box_axes(i).col(0) * box.half_extents.x();
        const Vec3 z = statics.box_axes(i).col(2) * box.half_extents.z();
        const std::array<Vec3, 4> corners = {
            box.centre - x - z, box.centre + x - z, box.centre + x + z, box.centre - x + z};
        for (std::size_t c = 0; c < corners.size(); ++c) {
            const Vec3& from = corners[c];
            const Vec3& to = corners[(c + 1) % corners.size()];
            sides.push_back({from.x(), from.z(), to.x(), to.z()});
        }
    }
    auto made = Walls::make(sides, cell_m);
    ZONED_ASSERT(made.ok(), "static boxes lie within the world");
    return std::move(*made);
}

}  // namespace zoned::ai::steering
