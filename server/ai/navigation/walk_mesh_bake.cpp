#include "server/ai/navigation/box_column.h"
#include "server/ai/navigation/walk_mesh.h"

#include <recastnavigation/Recast.h>

#include <memory>
#include <numbers>
#include <string>

namespace zoned::ai::navigation {

namespace {

constexpr int kMostSteps = (1 << RC_SPAN_HEIGHT_BITS) - 1;
constexpr float kContourError = 1.3F;  // as in Recast's demonstration
constexpr int kMinRegion = 8;
constexpr int kMergeRegion = 20;

template <auto Free>
struct FreeRecast {
    template <class T>
    void operator()(T* p) const {
        Free(p);
    }
};

template <class T, auto Free>
using Recast = std::unique_ptr<T, FreeRecast<Free>>;

}  // namespace

/// From static geometry to polygons, step by step.
class MeshBakery {
  public:
    MeshBakery(const motion::StaticGeometry& world,
               const motion::CharacterLimits& limits,
               const GroundGrid& grid,
               const MeshSettings& settings)
        : world_(world),
          limits_(limits),
          grid_(grid),
          settings_(settings) {}

    core::Result<WalkMesh> run() {
        using R = core::Result<WalkMesh>;
        low_ = world_.ground_height() - settings_.cell_height_m;
        high_ = world_.ground_height();
        for (std::uint32_t i = 0; i < world_.boxes().size(); ++i) {
            high_ = std::max(high_, world_.box_bounds(i).upper.y());
        }
        for (const motion::PlacedSurface& s : world_.surfaces()) {
            low_ = std::min(low_, s.bounds().lower.y() - settings_.cell_height_m);
            high_ = std::max(high_, s.bounds().upper.y());
        }
        high_ += 2.0F * (limits_.radius + limits_.half_segment) + settings_.cell_height_m;
        if (!((high_ - low_) / settings_.cell_height_m < static_cast<float>(kMostSteps))) {
            return R::failure("more than " + std::to_string(kMostSteps) + " steps of " +
                              std::to_string(settings_.cell_height_m) +
                              " m between the lowest and the highest place");
        }
        const std::array<float, 3> lower{grid_.min_x(), low_, grid_.min_z()};
        const std::array<float, 3> upper{
            grid_.min_x() + grid_.cell_m() * static_cast<float>(grid_.width()),
            high_,
            grid_.min_z() + grid_.cell_m() * static_cast<float>(grid_.height())};
        if (!rcCreateHeightfield(&context_,
                                 *field_,
                                 grid_.width(),
                                 grid_.height(),
                                 lower.data(),
                                 upper.data(),
                                 settings_.cell_m,
                                 settings_.cell_height_m)) {
            return R::failure("Recast has no room for a heightfield");
        }
        climb_ = static_cast<int>(limits_.step_up / settings_.cell_height_m + 1e-3F);
        fill_columns();
        add_surfaces();
        return polygons();
    }

  private:
    [[nodiscard]] int step_of(float y) const {
        return std::clamp(
            static_cast<int>(std::lround((y - low_) / settings_.cell_height_m)), 0, kMostSteps);
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
                  climb_);
    }

    /// The ground plane and the boxes.
    void fill_columns() {
        for (int z = 0; z < grid_.height(); ++z) {
            for (int x = 0; x < grid_.width(); ++x) {
                const Spot at =
                    grid_.centre({static_cast<std::uint16_t>(x), static_cast<std::uint16_t>(z)});
                add(x, z, low_, world_.ground_height(), true);
                const Aabb line{Vec3(at.x, low_, at.z), Vec3(at.x, high_, at.z)};
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
        const float slope = std::acos(limits_.max_slope_cos) * 180.0F / std::numbers::pi_v<float>;
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
                &context_, corners.data(), areas.data(), triangles, *field_, climb_);
            if (s.surface().is_grid()) {
                fill_below(s);
            }
        }
    }

    /// What lies below heights is solid.
    void fill_below(const motion::PlacedSurface& s) {
        for (int z = 0; z < grid_.height(); ++z) {
            for (int x = 0; x < grid_.width(); ++x) {
                const Spot at =
                    grid_.centre({static_cast<std::uint16_t>(x), static_cast<std::uint16_t>(z)});
                const std::optional<float> top = s.top_at(at.x, at.z);
                if (top && *top - 2.0F * settings_.cell_height_m > low_) {
                    add(x, z, low_, *top - 2.0F * settings_.cell_height_m, false);
                }
            }
        }
    }

    core::Result<WalkMesh> polygons() {
        using R = core::Result<WalkMesh>;
        const float tall = 2.0F * (limits_.radius + limits_.half_segment);
        const int height = static_cast<int>(std::ceil(tall / settings_.cell_height_m));
        const int radius = static_cast<int>(std::ceil(limits_.radius / settings_.cell_m - 1e-3F));
        rcFilterLowHangingWalkableObstacles(&context_, climb_, *field_);
        rcFilterLedgeSpans(&context_, height, climb_, *field_);
        rcFilterWalkableLowHeightSpans(&context_, height, *field_);
        const bool built =
            rcBuildCompactHeightfield(&context_, height, climb_, *field_, *compact_) &&
            rcErodeWalkableArea(&context_, radius, *compact_) &&
            rcBuildDistanceField(&context_, *compact_) &&
            rcBuildRegions(&context_, *compact_, 0, kMinRegion, kMergeRegion) &&
            rcBuildContours(&context_, *compact_, kContourError, 0, *contours_) &&
            rcBuildPolyMesh(&context_, *contours_, WalkMesh::kMostCorners, *mesh_);
        if (!built) {
            return R::failure("Recast can't build polygons of this ground");
        }
        WalkMesh out;
        for (int i = 0; i < mesh_->nverts; ++i) {
            const unsigned short* v = mesh_->verts + std::ptrdiff_t{3} * i;
            out.vertices_.emplace_back(grid_.min_x() + settings_.cell_m * v[0],
                                       low_ + settings_.cell_height_m * v[1],
                                       grid_.min_z() + settings_.cell_m * v[2]);
        }
        for (int i = 0; i < mesh_->npolys; ++i) {
            const unsigned short* p = mesh_->polys + std::ptrdiff_t{2} * WalkMesh::kMostCorners * i;
            WalkMesh::Polygon polygon;
            for (int k = 0; k < WalkMesh::kMostCorners && p[k] != RC_MESH_NULL_IDX; ++k) {
                const unsigned short beyond = p[WalkMesh::kMostCorners + k];
                polygon.corners[static_cast<std::size_t>(k)] = p[k];
                polygon.neighbours[static_cast<std::size_t>(k)] =
                    (beyond & 0x8000U) != 0 ? WalkMesh::kNone : beyond;
                ++polygon.size;
            }
            out.polygons_.push_back(polygon);
        }
        out.index_polygons();
        return out;
    }

    const motion::StaticGeometry& world_;
    const motion::CharacterLimits& limits_;
    const GroundGrid& grid_;
    const MeshSettings& settings_;
    float low_ = 0.0F;
    float high_ = 0.0F;
    int climb_ = 0;
    rcContext context_{false};
    Recast<rcHeightfield, rcFreeHeightField> field_{rcAllocHeightfield()};
    Recast<rcCompactHeightfield, rcFreeCompactHeightfield> compact_{rcAllocCompactHeightfield()};
    Recast<rcContourSet, rcFreeContourSet> contours_{rcAllocContourSet()};
    Recast<rcPolyMesh, rcFreePolyMesh> mesh_{rcAllocPolyMesh()};
};

core::Result<WalkMesh> WalkMesh::bake(const motion::StaticGeometry& world,
                                      const motion::CharacterLimits& limits,
                                      const GroundRect& area,
                                      const MeshSettings& settings) {
    using R = core::Result<WalkMesh>;
    const std::string defect = GroundGrid::defect_of(area, settings.cell_m);
    if (!defect.empty()) {
        return R::failure(defect);
    }
    if (!(settings.cell_height_m > 0.0F)) {
        return R::failure("steps of height need a size above 0 m");
    }
    const GroundGrid grid(area, settings.cell_m);
    return MeshBakery(world, limits, grid, settings).run();
}

}  // namespace zoned::ai::navigation
