#include "server/physics/particles/flock_path.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <span>

namespace zoned::physics {

namespace {

/// `open`: beyond the last point there is nothing to go along.
Vec2d direction_near(std::span<const Vec2d> path, bool open, const Vec2d& at, double width) {
    double least = std::numeric_limits<double>::max();
    Vec2d offset = Vec2d::Zero();
    Vec2d tangent = Vec2d::Zero();
    for (std::size_t i = 0; i + 1 < path.size(); ++i) {
        const Vec2d piece = path[i + 1] - path[i];
        const double length2 = piece.squaredNorm();
        const double t =
            length2 > 0.0 ? std::clamp(piece.dot(at - path[i]) / length2, 0.0, 1.0) : 0.0;
        const Vec2d to = path[i] + t * piece - at;
        if (to.squaredNorm() < least && length2 > 0.0) {
            least = to.squaredNorm();
            offset = to;
            const bool at_end = open && i + 2 == path.size() && t >= 1.0;
            tangent = at_end ? Vec2d(Vec2d::Zero()) : Vec2d(piece / std::sqrt(length2));
        }
    }
    const Vec2d wanted = tangent + offset / width;
    const double norm = wanted.norm();
    return norm > 0.0 ? Vec2d(wanted / std::max(norm, 1e-6)) : Vec2d(Vec2d::Zero());
}

}  // namespace

std::vector<float> directions_along(const FlockDef& def, kernels::FlockRules& rules) {
    const Vec2d low(def.low.x(), def.low.z());
    const Vec2d size = Vec2d(def.high.x(), def.high.z()) - low;
    const double cell =
        std::max(static_cast<double>(def.path_width) / 4.0, size.maxCoeff() / kMostPathCells);
    const auto columns = static_cast<int>(std::ceil(size.x() / cell));
    const auto rows = static_cast<int>(std::ceil(size.y() / cell));
    rules.follow = def.follow;
    rules.field_x0 = static_cast<float>(low.x());
    rules.field_z0 = static_cast<float>(low.y());
    rules.field_cells_per_m = static_cast<float>(1.0 / cell);
    rules.field_columns = columns;
    rules.field_rows = rows;
    std::vector<Vec2d> path = def.path;
    if (def.closed) {
        path.push_back(path.front());
    }
    std::vector<float> directions;
    directions.reserve(2 * static_cast<std::size_t>(columns) * static_cast<std::size_t>(rows));
    for (int row = 0; row < rows; ++row) {
        for (int column = 0; column < columns; ++column) {
            const Vec2d at = low + cell * Vec2d(column + 0.5, row + 0.5);
            const Vec2d to =
                direction_near(path, !def.closed, at, static_cast<double>(def.path_width));
            directions.push_back(static_cast<float>(to.x()));
            directions.push_back(static_cast<float>(to.y()));
        }
    }
    return directions;
}

}  // namespace zoned::physics
