#include "server/ai/pathfinding/flow_fields/flock_flow_field.h"

#include "shared/core/assert.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace zoned::ai::pathfinding {

namespace {

Vec2 direction_near(std::span<const Vec2> path, const Vec2& at, float width_m) {
    float least = std::numeric_limits<float>::max();
    Vec2 offset = Vec2::Zero();
    Vec2 tangent = Vec2::Zero();
    for (std::size_t i = 0; i + 1 < path.size(); ++i) {
        const Vec2 piece = path[i + 1] - path[i];
        const float length2 = piece.squaredNorm();
        const float t =
            length2 > 0.0F ? std::clamp(piece.dot(at - path[i]) / length2, 0.0F, 1.0F) : 0.0F;
        const Vec2 to = path[i] + t * piece - at;
        if (to.squaredNorm() < least && length2 > 0.0F) {
            least = to.squaredNorm();
            offset = to;
            // Beyond the end there is nothing to go along.
            const bool at_end = i + 2 == path.size() && t >= 1.0F;
            tangent = at_end ? Vec2(Vec2::Zero()) : Vec2(piece / std::sqrt(length2));
        }
    }
    const Vec2 wanted = tangent + offset / width_m;
    const float norm = wanted.norm();
    return norm > 0.0F ? Vec2(wanted / std::max(norm, 1e-6F)) : Vec2(Vec2::Zero());
}

}  // namespace

void FlockFlowField::steer(kernels::FlockRules& rules, float follow) const {
    rules.follow = follow;
    rules.field_x0 = x0;
    rules.field_z0 = z0;
    rules.field_cells_per_m = 1.0F / cell_m;
    rules.field_columns = columns;
    rules.field_rows = rows;
}

FlockFlowField along_path(std::span<const Vec2> path,
                          const FlockFlowField& rectangle,
                          float width_m) {
    ZONED_ASSERT(path.size() >= 2 && width_m > 0.0F, "a path has two points and a width");
    FlockFlowField made = rectangle;
    made.directions.clear();
    for (int row = 0; row < made.rows; ++row) {
        for (int column = 0; column < made.columns; ++column) {
            const Vec2 at(made.x0 + (static_cast<float>(column) + 0.5F) * made.cell_m,
                          made.z0 + (static_cast<float>(row) + 0.5F) * made.cell_m);
            const Vec2 direction = direction_near(path, at, width_m);
            made.directions.push_back(direction.x());
            made.directions.push_back(direction.y());
        }
    }
    return made;
}

FlockFlowField to_goal(const GridMap& map,
                       const FlowField& field,
                       float x0,
                       float z0,
                       float cell_m) {
    FlockFlowField made{x0, z0, cell_m, map.width(), map.height(), {}};
    for (int row = 0; row < made.rows; ++row) {
        for (int column = 0; column < made.columns; ++column) {
            const Cell c{static_cast<std::uint16_t>(column), static_cast<std::uint16_t>(row)};
            const Cell next = hopped(c, field.hop(map.place(c)));
            const Vec2 step(static_cast<float>(next.x) - static_cast<float>(c.x),
                            static_cast<float>(next.y) - static_cast<float>(c.y));
            const float norm = std::max(step.norm(), 1.0F);
            made.directions.push_back(step.x() / norm);
            made.directions.push_back(step.y() / norm);
        }
    }
    return made;
}

}  // namespace zoned::ai::pathfinding
