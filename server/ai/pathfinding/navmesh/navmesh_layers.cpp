#include "server/ai/pathfinding/navmesh/navmesh_layers.h"

#include "server/ai/pathfinding/grid/box_column.h"
#include "server/ai/pathfinding/navmesh/recast_owned.h"
#include "shared/core/elementary/elementary.h"

#include <array>
#include <numbers>

namespace zoned::ai::pathfinding {

namespace {

constexpr int kMostSteps = (1 << RC_SPAN_HEIGHT_BITS) - 1;

/// From static geometry to solid columns, and to the floors between them.
class FloorSurvey {
  public:
    FloorSurvey(const motion::StaticGeometry& world,
                const motion::CharacterLimits& limits,
                const FloorFrame& frame)
        : world_(world),
          limits_(limits),
          frame_(frame) {}

    core::Result<NavmeshLayers> run() {
        using R = core::Result<NavmeshLayers>;
        const GroundGrid& g = frame_.grid;
        const std::array<float, 3> lower{g.min_x(), frame_.low_m, g.min_z()};
        const std::array<float, 3> upper{g.min_x() + g.cell_m() * static_cast<float>(g.width()),
                                         frame_.high_m,
                                         g.min_z() + g.cell_m() * static_cast<float>(g.height())};
        if (!rcCreateHeightfield(&context_,
                                 *field_,
                                 g.width(),
                                 g.height(),
                                 lower.data(),
                                 upper.data(),
                                 g.cell_m(),
                                 frame_.step_m)) {
            return R::failure("Recast has no room for a heightfield");
        }
        fill_columns();
        add_surfaces();
        rcFilterLowHangingWalkableObstacles(&context_, frame_.climb_steps, *field_);
        rcFilterLedgeSpans(&context_, frame_.height_steps, frame_.climb_steps, *field_);
        rcFilterWalkableLowHeightSpans(&context_, frame_.height_steps, *field_);
        if (!rcBuildCompactHeightfield(
                &context_, frame_.height_steps, frame_.climb_steps, *field_, *compact_) ||
            !rcErodeWalkableArea(&context_, frame_.radius_cells, *compact_)) {
            return R::failure("Recast has no room for the floors");
        }
        return floors();
    }

  private:
    [[nodiscard]] int step_of(float y) const {
        return std::clamp(
            static_cast<int>(std::lround((y - frame_.low_m) / frame_.step_m)), 0, kMostSteps);
    }

    void add(int x, int z, float bottom, float top, bool carries) {
        const int from = step_of(bottom);
        const int to = std::max(step_of(top), from + 1);
        rcAddSpan(&context_,
                  *field_,
                  x,
                  z,
                  static_cast<unsigned short>(from),
                  static_cast<unsigned short>(to),
                  carries ? RC_WALKABLE_AREA : RC_NULL_AREA,
                  frame_.climb_steps);
    }

    /// The ground plane and the boxes.
    void fill_columns() {
        for (int z = 0; z < frame_.grid.height(); ++z) {
            for (int x = 0; x < frame_.grid.width(); ++x) {
                const Spot at = frame_.grid.centre(
                    {static_cast<std::uint16_t>(x), static_cast<std::uint16_t>(z)});
                add(x, z, frame_.low_m, world_.ground_height(), true);
                const Aabb line{Vec3(at.x, frame_.low_m, at.z), Vec3(at.x, frame_.high_m, at.z)};
                world_.for_each_near(line, [&](std::uint32_t box) {
                    const auto column = column_of_box(world_, box, at.x, at.z);
                    if (column && column->top > world_.ground_height()) {
                        add(x, z, column->bottom, column->top, column->up >= limits_.max_slope_cos);
                    }
                });
            }
        }
    }

    void add_surfaces() {
        const float slope =
            elementary::acos(limits_.max_slope_cos) * 180.0F / std::numbers::pi_v<float>;
        std::vector<float> corners;
        std::vector<int> order;
        for (const motion::PlacedSurface& s : world_.surfaces()) {
            corners.clear();
            order.clear();
            s.surface().for_each_near(s.surface().box(), [&](const FacedTriangle& t) {
                for (const Vec3& c : t.corner) {
                    const Vec3 at = s.to_world(c);
                    order.push_back(static_cast<int>(order.size()));
                    corners.insert(corners.end(), {at.x(), at.y(), at.z()});
                }
            });
            const int triangles = static_cast<int>(order.size() / 3);
            std::vector<unsigned char> areas(static_cast<std::size_t>(triangles), RC_NULL_AREA);
            rcMarkWalkableTriangles(&context_,
                                    slope,
                                    corners.data(),
                                    3 * triangles,
                                    order.data(),
                                    triangles,
                                    areas.data());
            rcRasterizeTriangles(
                &context_, corners.data(), areas.data(), triangles, *field_, frame_.climb_steps);
            if (s.surface().is_grid()) {
                fill_below(s);
            }
        }
    }

    /// The space below a height grid is solid.
    void fill_below(const motion::PlacedSurface& s) {
        for (int z = 0; z < frame_.grid.height(); ++z) {
            for (int x = 0; x < frame_.grid.width(); ++x) {
                const Spot at = frame_.grid.centre(
                    {static_cast<std::uint16_t>(x), static_cast<std::uint16_t>(z)});
                const std::optional<float> top = s.top_at(at.x, at.z);
                if (top && *top - 2.0F * frame_.step_m > frame_.low_m) {
                    add(x, z, frame_.low_m, *top - 2.0F * frame_.step_m, false);
                }
            }
        }
    }

    [[nodiscard]] NavmeshLayers floors() const {
        NavmeshLayers out;
        const std::size_t columns =
            static_cast<std::size_t>(compact_->width) * static_cast<std::size_t>(compact_->height);
        out.first.reserve(columns + 1);
        out.first.push_back(0);
        for (std::size_t c = 0; c < columns; ++c) {
            const rcCompactCell& cell = compact_->cells[c];
            for (unsigned i = cell.index, end = i + cell.count; i < end; ++i) {
                if (compact_->areas[i] != RC_NULL_AREA) {
                    const rcCompactSpan& span = compact_->spans[i];
                    out.floors.push_back({span.y, static_cast<std::uint8_t>(span.h)});
                }
            }
            out.first.push_back(static_cast<std::uint32_t>(out.floors.size()));
        }
        return out;
    }

    const motion::StaticGeometry& world_;
    const motion::CharacterLimits& limits_;
    const FloorFrame& frame_;
    rcContext context_{false};
    RecastHeights field_{rcAllocHeightfield()};
    RecastFloors compact_{rcAllocCompactHeightfield()};
};

}  // namespace

FloorFrame floor_frame(const motion::StaticGeometry& world,
                       const motion::CharacterLimits& limits,
                       const GroundRect& area,
                       float cell_m,
                       float step_m) {
    FloorFrame frame{GroundGrid(area, cell_m)};
    frame.step_m = step_m;
    frame.low_m = world.ground_height() - step_m;
    frame.high_m = world.ground_height();
    const auto boxes = static_cast<std::uint32_t>(world.boxes().size() + world.doors().size());
    for (std::uint32_t i = 0; i < boxes; ++i) {
        frame.high_m = std::max(frame.high_m, world.box_bounds(i).upper.y());
    }
    for (const motion::PlacedSurface& s : world.surfaces()) {
        frame.low_m = std::min(frame.low_m, s.bounds().lower.y() - step_m);
        frame.high_m = std::max(frame.high_m, s.bounds().upper.y());
    }
    const float tall = 2.0F * (limits.radius + limits.half_segment);
    frame.high_m += tall + step_m;
    frame.height_steps = static_cast<int>(std::ceil(tall / step_m));
    frame.climb_steps = static_cast<int>(limits.step_up / step_m + 1e-3F);
    frame.radius_cells = static_cast<int>(std::ceil(limits.radius / cell_m - 1e-3F));
    return frame;
}

std::string frame_defect(const FloorFrame& frame) {
    if ((frame.high_m - frame.low_m) / frame.step_m < static_cast<float>(kMostSteps)) {
        return {};
    }
    return "more than " + std::to_string(kMostSteps) + " steps of " + std::to_string(frame.step_m) +
           " m between the lowest and the highest place";
}

core::Result<NavmeshLayers> navmesh_layers(const motion::StaticGeometry& world,
                                           const motion::CharacterLimits& limits,
                                           const FloorFrame& frame) {
    return FloorSurvey(world, limits, frame).run();
}

}  // namespace zoned::ai::pathfinding
