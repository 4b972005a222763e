// Navmesh: where characters of one size can walk, as convex polygons over any number of floors.
#pragma once

#include "server/ai/pathfinding/grid/grid_query.h"
#include "server/ai/pathfinding/grid/ground_grid.h"
#include "server/ai/pathfinding/grid/search_heap.h"
#include "server/spatial/cell_lists.h"
#include "shared/core/result.h"
#include "shared/motion/apply_input.h"

#include <array>
#include <compare>
#include <cstdint>
#include <span>
#include <vector>

namespace zoned::ai::pathfinding {

struct NavmeshSettings {
    float cell_m = 0.25F;         ///< of the heightfield that polygons are found on
    float cell_height_m = 0.05F;  ///< its steps of height
};

/// Polygons share edges with their neighbours. Baked by Recast (Mononen) from solid columns: the
/// ground plane, boxes through and through, height grids down to the bottom, and the triangles of
/// other surfaces. Recast's rules decide what can be walked: headroom, slope, a step's height, and
/// distance to walls and edges, each rounded to cells. Unlike movement it knows no rims, so that
/// GroundMap is nearer to the truth where a zone has one floor. Within a polygon heights are those
/// of triangles that Recast lays over its floors, 0.2 m off where it looks (every 4 cells); along
/// its edges they are those of its corners.
///
/// Doors: the ground is baked without them and with each of them shut. What that takes away or
/// gives (a bridge) is polygons of its own, as an area of Recast's, so that a door that turns
/// changes which polygons are passable, and nothing else: the mesh is that of the ground as it is,
/// to within Recast's own contours.
class Navmesh {
  public:
    static constexpr int kMostCorners = 6;
    static constexpr std::uint32_t kNone = ~0U;
    /// Who is no farther from a floor in height, m, stands on it.
    static constexpr float kOnFloor_m = 1.0F;

    struct Polygon {
        std::array<std::uint32_t, kMostCorners> corners{};
        std::array<std::uint32_t, kMostCorners>
            neighbours{};  ///< beyond the edge that begins there
        int size = 0;
        std::uint32_t gate = 0;  ///< of gates(): whose doors it hangs on
    };

    /// Doors that polygons hang on, by their numbers: passable while none of `takers` is shut, and
    /// if it is not `open`, any of `givers` is. The first one hangs on none.
    struct Gate {
        bool open = true;  ///< ground while no door is shut
        std::vector<std::uint32_t> takers;
        std::vector<std::uint32_t> givers;

        friend auto operator<=>(const Gate&, const Gate&) = default;
    };

    /// What can't be: no room for a cell, too many cells, more height than Recast counts, or a step
    /// of Recast's that failed.
    static core::Result<Navmesh> bake(const motion::StaticGeometry& world,
                                      const motion::CharacterLimits& limits,
                                      const GroundRect& area,
                                      const NavmeshSettings& settings = {});

    /// Polygons from elsewhere: corners in order, in either sense, neighbours beyond each edge.
    static Navmesh of(std::vector<Vec3> vertices, std::vector<Polygon> polygons);

    [[nodiscard]] std::span<const Vec3> vertices() const { return vertices_; }

    [[nodiscard]] std::span<const Polygon> polygons() const { return polygons_; }

    [[nodiscard]] std::span<const Gate> gates() const { return gates_; }

    /// Edges that lie no farther from a side of what was baked lie at its end, m.
    [[nodiscard]] float rim_m() const { return rim_m_; }

    /// Whether it can be walked on now.
    [[nodiscard]] bool passable(std::uint32_t polygon) const { return passable_[polygon] != 0; }

    /// Until doors are said to be otherwise they are as with none of them shut.
    void set_passable(std::uint32_t polygon, bool passable) {
        passable_[polygon] = passable ? 1 : 0;
    }

    /// The passable polygon that a place is on: the one below or above it that is nearest in
    /// height, by no more than `height_m`. Where that is not within kOnFloor_m, or there is none,
    /// one beside it whose edge is nearer (in three dimensions), no farther than `reach_m`, and
    /// within kOnFloor_m in height if there is one below or above: at the rim of a bridge one is
    /// on the bridge. kNone: there is none. `on` becomes the place on it. A place whose height is
    /// not a number is on the ground: the lowest polygon there.
    [[nodiscard]] std::uint32_t nearest(const Vec3& place,
                                        float reach_m,
                                        float height_m,
                                        Vec3& on) const;

    [[nodiscard]] std::uint32_t nearest(const Vec3& place, float reach_m, Vec3& on) const {
        return nearest(place, reach_m, reach_m, on);
    }

    /// The nearest place of a polygon, in three dimensions.
    [[nodiscard]] Vec3 nearest_on(std::uint32_t polygon, const Vec3& place) const;

    /// Walks straight from a place on a polygon to another over passable polygons: the one on which
    /// it comes to `to`, kNone where the line leaves them. Calls `visit(polygon)` for each, the
    /// first among them. Heights follow the polygons.
    template <class Visit>
    std::uint32_t walk(std::uint32_t polygon,
                       const Vec3& from,
                       const Vec3& to,
                       Visit&& visit) const;

    [[nodiscard]] std::size_t bytes() const;

  private:
    friend class NavmeshBaker;

    /// Where a line leaves a polygon: the edge, or -1 where it ends in it.
    [[nodiscard]] int exit_edge(std::uint32_t polygon,
                                std::uint32_t before,
                                const Vec3& from,
                                const Vec3& to) const;
    /// Whether a place is above or below a polygon, whose height there is `height`.
    [[nodiscard]] bool over(std::uint32_t polygon, const Vec3& place, float& height) const;
    /// The nearest place of a polygon's edge `i`, over x and z.
    [[nodiscard]] Vec3 nearest_on_edge(std::uint32_t polygon, int i, const Vec3& place) const;
    /// The height of a place on a polygon; `height` where its corners tell all.
    [[nodiscard]] float relief_at(std::uint32_t polygon, const Vec3& place, float height) const;
    /// All polygons turn the same way round; they are listed by cells.
    void finish();
    void index_polygons();

    std::vector<Vec3> vertices_;
    std::vector<Polygon> polygons_;
    std::vector<Gate> gates_{1};
    std::vector<std::uint8_t> passable_;  // by polygon
    // Triangles over the floors of each polygon, those of polygon p from relief_first_[p] on; none
    // for polygons from elsewhere, and where the corners' heights are those of all.
    std::vector<std::array<Vec3, 3>> relief_;
    std::vector<std::uint32_t> relief_first_;  // by polygon, and one more; or empty
    float rim_m_ = 0.0F;
    // Polygons by cells over x and z in which their bounds lie.
    float min_x_ = 0.0F;
    float min_z_ = 0.0F;
    int across_ = 1;
    int down_ = 1;
    spatial::CellLists listed_;
};

template <class Visit>
std::uint32_t Navmesh::walk(std::uint32_t polygon,
                            const Vec3& from,
                            const Vec3& to,
                            Visit&& visit) const {
    std::uint32_t before = kNone;
    // No line passes through a convex polygon twice.
    for (std::size_t steps = 0; steps <= polygons_.size(); ++steps) {
        visit(polygon);
        const int edge = exit_edge(polygon, before, from, to);
        if (edge < 0) {
            return polygon;
        }
        const std::uint32_t next = polygons_[polygon].neighbours[static_cast<std::size_t>(edge)];
        if (next == kNone || !passable(next)) {
            return kNone;
        }
        before = polygon;
        polygon = next;
    }
    return kNone;
}

/// A* over passable polygons, then the string pulled straight through the edges between them (the
/// funnel of Lee and Preparata, "Euclidean shortest paths in the presence of rectilinear barriers",
/// Networks 14, 1984). The corridor is chosen by the middles of edges: the path is near the best.
/// Memory for one query at a time, none allocated once warm.
class NavmeshSearch {
  public:
    struct NavmeshAnswer {
        PathOutcome outcome = PathOutcome::kUnreachable;
        float length_m = 0.0F;
        std::uint32_t work = 0;  ///< polygons looked at
    };

    /// kStartBlocked and kGoalBlocked: no polygon within `reach_m`.
    NavmeshAnswer plan(const Navmesh& mesh,
                       const Vec3& from,
                       const Vec3& to,
                       float reach_m,
                       std::uint32_t max_work = ~0U);

    /// The same between places on polygons.
    NavmeshAnswer plan(const Navmesh& mesh,
                       std::uint32_t first,
                       std::uint32_t last,
                       const Vec3& from,
                       const Vec3& to,
                       std::uint32_t max_work = ~0U);

    /// Along polygons each of which is a neighbour of the one before it, from the first to the
    /// last: corners and length.
    NavmeshAnswer follow(const Navmesh& mesh,
                         std::span<const std::uint32_t> polygons,
                         const Vec3& from,
                         const Vec3& to);

    /// Of the last answer that was found, with both ends.
    [[nodiscard]] std::span<const Vec3> corners() const { return corners_; }

    /// Its polygons, from start to goal.
    [[nodiscard]] std::span<const std::uint32_t> corridor() const { return corridor_; }

    /// By corner: so many polygons of the corridor, its first ones, are behind who stands there.
    [[nodiscard]] std::span<const std::uint32_t> passed() const { return passed_; }

    [[nodiscard]] std::size_t bytes() const;

  private:
    struct KnownPolygon {
        float cost = 0.0F;
        std::uint32_t from = 0;
        std::uint32_t search = 0;
        Vec3 entry = Vec3::Zero();  ///< where it was entered
    };

    struct OpenPolygon {
        float key;           ///< estimate of the whole path
        std::uint32_t node;  ///< polygon
        float cost;
    };

    bool find(const Navmesh& mesh,
              std::uint32_t first,
              std::uint32_t last,
              const Vec3& from,
              const Vec3& to,
              std::uint32_t max_work,
              NavmeshAnswer& answer);
    void reach(std::uint32_t polygon,
               float cost,
               std::uint32_t from,
               const Vec3& entry,
               const Vec3& to);
    void pull(const Navmesh& mesh, const Vec3& from, const Vec3& to);
    void turn_at(const Vec3& corner, std::size_t gate);
    [[nodiscard]] float length() const;

    std::vector<KnownPolygon> known_;
    SearchHeap<OpenPolygon> open_;
    std::uint32_t search_ = 0;
    std::vector<std::uint32_t> corridor_;
    std::vector<std::array<Vec3, 2>> gates_;  // left and right ends of the edges passed through
    std::vector<Vec3> corners_;
    std::vector<std::uint32_t> passed_;
};

}  // namespace zoned::ai::pathfinding
