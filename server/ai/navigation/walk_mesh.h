// WalkMesh: where characters of one size can walk, as convex polygons over any number of floors.
#pragma once

#include "server/ai/navigation/ground_grid.h"
#include "server/ai/navigation/query.h"
#include "shared/core/result.h"
#include "shared/motion/apply_input.h"

#include <array>
#include <cstdint>
#include <span>
#include <vector>

namespace zoned::ai::navigation {

struct MeshSettings {
    float cell_m = 0.25F;         ///< of the heightfield that polygons are found on
    float cell_height_m = 0.05F;  ///< its steps of height
};

/// Polygons share edges with their neighbours. Baked by Recast (Mononen) from solid columns: the
/// ground plane, boxes through and through, height grids down to the bottom, and the triangles of
/// other surfaces. Recast's rules decide what can be walked: headroom, slope, a step's height, and
/// distance to walls and edges, each rounded to cells. Unlike movement it knows no rims, so that
/// GroundMap is nearer to the truth where a zone has one floor.
class WalkMesh {
  public:
    static constexpr int kMostCorners = 6;
    static constexpr std::uint32_t kNone = ~0U;

    struct Polygon {
        std::array<std::uint32_t, kMostCorners> corners{};
        std::array<std::uint32_t, kMostCorners>
            neighbours{};  ///< beyond the edge that begins there
        int size = 0;
    };

    /// What can't be: no room for a cell, too many cells, more height than Recast counts, or a step
    /// of Recast's that failed.
    static core::Result<WalkMesh> bake(const motion::StaticGeometry& world,
                                       const motion::CharacterLimits& limits,
                                       const GroundRect& area,
                                       const MeshSettings& settings = {});

    [[nodiscard]] std::span<const Vec3> vertices() const { return vertices_; }

    [[nodiscard]] std::span<const Polygon> polygons() const { return polygons_; }

    /// The polygon below or above a place, that is nearest in height; beside all of them the one
    /// whose edge is nearest, no farther than `reach_m`; else kNone. `on` becomes the place on it.
    [[nodiscard]] std::uint32_t nearest(const Vec3& place, float reach_m, Vec3& on) const;

    [[nodiscard]] std::size_t bytes() const;

  private:
    friend class MeshBakery;

    [[nodiscard]] bool over(const Polygon& polygon, const Vec3& place, float& height) const;
    void index_polygons();

    std::vector<Vec3> vertices_;
    std::vector<Polygon> polygons_;
    // Polygons by cells over x and z in which their bounds lie.
    float min_x_ = 0.0F;
    float min_z_ = 0.0F;
    int across_ = 1;
    int down_ = 1;
    std::vector<std::uint32_t> first_;  // by cell, and one more
    std::vector<std::uint32_t> listed_;
};

/// A* over polygons, then the string pulled straight through the edges between them (the funnel of
/// Lee and Preparata, "Euclidean shortest paths in the presence of rectilinear barriers", Networks
/// 14, 1984). The corridor is chosen by the middles of edges: the way is near the best. Memory for
/// one query at a time, none allocated once warm.
class MeshSearch {
  public:
    struct Answer {
        Outcome outcome = Outcome::kUnreachable;
        float length_m = 0.0F;
        std::uint32_t work = 0;  ///< polygons looked at
    };

    /// kStartBlocked and kGoalBlocked: no polygon within `reach_m`.
    Answer plan(const WalkMesh& mesh,
                const Vec3& from,
                const Vec3& to,
                float reach_m,
                std::uint32_t max_work = ~0U);

    /// Of the last answer that was found, with both ends.
    [[nodiscard]] std::span<const Vec3> corners() const { return corners_; }

  private:
    struct Known {
        float cost = 0.0F;
        std::uint32_t from = 0;
        std::uint32_t search = 0;
        Vec3 entry = Vec3::Zero();  ///< where it was entered
    };

    struct Open {
        float estimate;
        float cost;
        std::uint32_t polygon;
    };

    bool find(const WalkMesh& mesh,
              std::uint32_t first,
              std::uint32_t last,
              const Vec3& from,
              const Vec3& to,
              std::uint32_t max_work,
              Answer& answer);
    void reach(std::uint32_t polygon,
               float cost,
               std::uint32_t from,
               const Vec3& entry,
               const Vec3& to);
    void pull(const WalkMesh& mesh, const Vec3& from, const Vec3& to);

    std::vector<Known> known_;
    std::vector<Open> open_;
    std::uint32_t search_ = 0;
    std::vector<std::uint32_t> corridor_;
    std::vector<std::array<Vec3, 2>> gates_;  // left and right ends of the edges passed through
    std::vector<Vec3> corners_;
};

}  // namespace zoned::ai::navigation
