// Navmesh: the ground for characters of one size, as convex polygons over any number of floors.
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
    float cell_m = 0.25F;         ///< cell side of the heightfield from which polygons are made
    float cell_height_m = 0.05F;  ///< height of its steps
};

/// Polygons share edges with their neighbours. Recast (Mononen) bakes them from solid columns: the
/// ground plane, boxes through and through, height grids down to the bottom, and the triangles of
/// other surfaces. Recast's rules decide where one can walk: headroom, slope, a step's height, and
/// distance to walls and edges, each rounded to cells. Unlike movement it has no rims, so GroundMap
/// is nearer to the truth where a zone has one floor. Within a polygon heights are those of
/// triangles that Recast lays over its floors, 0.2 m off at its samples (every 4 cells). Along its
/// edges they are those of its corners.
///
/// Doors: the ground is baked without them and with each of them shut. The ground that a door takes
/// away or gives (a bridge) has polygons of its own, as a Recast area. So a turning door changes
/// which polygons are passable, and nothing else. The mesh equals that of the present ground, to
/// within Recast's own contours.
class Navmesh {
  public:
    static constexpr int kMostCorners = 6;
    static constexpr std::uint32_t kNone = ~0U;
    /// An agent stands on a floor within this height of it, m.
    static constexpr float kOnFloor_m = 1.0F;

    struct Polygon {
        std::array<std::uint32_t, kMostCorners> corners{};
        std::array<std::uint32_t, kMostCorners>
            neighbours{};  ///< beyond the edge that begins there
        int size = 0;
        std::uint32_t gate = 0;  ///< index in gates() of the doors that it depends on
    };

    /// The doors that polygons depend on, by number. A polygon is passable while none of `takers`
    /// is shut. If it is not `open`, any of `givers` must also be shut. The first gate depends on
    /// no door.
    struct Gate {
        bool open = true;  ///< ground while no door is shut
        std::vector<std::uint32_t> takers;
        std::vector<std::uint32_t> givers;

        friend auto operator<=>(const Gate&, const Gate&) = default;
    };

    /// The reason why bake() cannot begin, or empty: no room for a cell, too many cells, or more
    /// height than Recast counts. Looks at the bounds of the world alone.
    static std::string defect_of(const motion::StaticGeometry& world,
                                 const motion::CharacterLimits& limits,
                                 const GroundRect& area,
                                 const NavmeshSettings& settings = {});

    /// Bakes a mesh. Errors: defect_of(), or a failed step of Recast.
    static core::Result<Navmesh> bake(const motion::StaticGeometry& world,
                                      const motion::CharacterLimits& limits,
                                      const GroundRect& area,
                                      const NavmeshSettings& settings = {});

    /// Makes a mesh of given polygons: corners in order, in either sense, neighbours beyond each
    /// edge.
    static Navmesh of(std::vector<Vec3> vertices, std::vector<Polygon> polygons);

    [[nodiscard]] std::span<const Vec3> vertices() const { return vertices_; }

    [[nodiscard]] std::span<const Polygon> polygons() const { return polygons_; }

    [[nodiscard]] std::span<const Gate> gates() const { return gates_; }

    /// Edges within this distance of a side of the baked area lie at its end, m.
    [[nodiscard]] float rim_m() const { return rim_m_; }

    /// True if one can walk on it now.
    [[nodiscard]] bool passable(std::uint32_t polygon) const { return passable_[polygon] != 0; }

    /// The state with all doors open holds until set otherwise.
    void set_passable(std::uint32_t polygon, bool passable) {
        passable_[polygon] = passable ? 1 : 0;
    }

    /// The passable polygon of a place: the one below or above it that is nearest in height, by no
    /// more than `height_m`. Where there is none within kOnFloor_m, it may be one beside the place
    /// instead. The one beside must have a nearer edge (in three dimensions), no farther than
    /// `reach_m`. Its height is within kOnFloor_m if there is a polygon below or above. So a place
    /// at the rim of a bridge is on the bridge. kNone: there is none. `on` becomes the place on the
    /// polygon. A place whose height is not a number is on the ground: the lowest polygon there.
    [[nodiscard]] std::uint32_t nearest(const Vec3& place,
                                        float reach_m,
                                        float height_m,
                                        Vec3& on) const;

    [[nodiscard]] std::uint32_t nearest(const Vec3& place, float reach_m, Vec3& on) const {
        return nearest(place, reach_m, reach_m, on);
    }

    /// The point of a polygon nearest to `place`, in three dimensions.
    [[nodiscard]] Vec3 nearest_on(std::uint32_t polygon, const Vec3& place) const;

    /// Walks straight from a place on a polygon to another over passable polygons. Returns the
    /// polygon on which it reaches `to`, or kNone where the line leaves them. Calls
    /// `visit(polygon)` for each, including the first. Heights follow the polygons.
    template <class Visit>
    std::uint32_t walk(std::uint32_t polygon,
                       const Vec3& from,
                       const Vec3& to,
                       Visit&& visit) const;

    [[nodiscard]] std::size_t bytes() const;

  private:
    friend class NavmeshBaker;

    /// The edge by which a line leaves a polygon, or -1 where the line ends in it.
    [[nodiscard]] int exit_edge(std::uint32_t polygon,
                                std::uint32_t before,
                                const Vec3& from,
                                const Vec3& to) const;
    /// True if a place is above or below a polygon; `height` gets the polygon's height there.
    [[nodiscard]] bool over(std::uint32_t polygon, const Vec3& place, float& height) const;
    /// The point of a polygon's edge `i` nearest to a place, over x and z.
    [[nodiscard]] Vec3 nearest_on_edge(std::uint32_t polygon, int i, const Vec3& place) const;
    /// The height of a place on a polygon; `height` where its corners decide the height.
    [[nodiscard]] float relief_at(std::uint32_t polygon, const Vec3& place, float height) const;
    /// Gives all polygons the same sense of rotation, and lists them by cells.
    void finish();
    void index_polygons();

    std::vector<Vec3> vertices_;
    std::vector<Polygon> polygons_;
    std::vector<Gate> gates_{1};
    std::vector<std::uint8_t> passable_;  // by polygon
    // Triangles over the floors of each polygon, those of polygon p from relief_first_[p] on. There
    // are none for given polygons, and where the corners decide all heights.
    std::vector<std::array<Vec3, 3>> relief_;
    std::vector<std::uint32_t> relief_first_;  // by polygon, and one more; or empty
    float rim_m_ = 0.0F;
    // Polygons by cells over x and z in which their bounds lie. They have their own grid beside
    // spatial::BoxGrid, whose boxes move: these lists are written once and then only read.
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

/// A* over passable polygons, then a string pulled straight through the edges between them
/// (funnel). Source: Lee and Preparata, "Euclidean shortest paths in the presence of rectilinear
/// barriers", Networks 14, 1984. The corridor is chosen by the middles of edges, so the path is
/// only near the best. It has memory for one query at a time, and allocates nothing once warm.
class NavmeshSearch {
  public:
    struct NavmeshAnswer {
        PathOutcome outcome = PathOutcome::kUnreachable;
        float length_m = 0.0F;
        std::uint32_t work = 0;  ///< polygons looked at
    };

    /// Plans between two places. kStartBlocked and kGoalBlocked: no polygon within `reach_m`.
    NavmeshAnswer plan(const Navmesh& mesh,
                       const Vec3& from,
                       const Vec3& to,
                       float reach_m,
                       std::uint32_t max_work = ~0U);

    /// The same between places whose polygons are known.
    NavmeshAnswer plan(const Navmesh& mesh,
                       std::uint32_t first,
                       std::uint32_t last,
                       const Vec3& from,
                       const Vec3& to,
                       std::uint32_t max_work = ~0U);

    /// The corners and length of a path along given polygons, from the first to the last. Each must
    /// be a neighbour of the one before it.
    NavmeshAnswer follow(const Navmesh& mesh,
                         std::span<const std::uint32_t> polygons,
                         const Vec3& from,
                         const Vec3& to);

    /// The corners of the last found path, with both ends.
    [[nodiscard]] std::span<const Vec3> corners() const { return corners_; }

    /// The path's polygons, from start to goal.
    [[nodiscard]] std::span<const std::uint32_t> corridor() const { return corridor_; }

    /// By corner: the number of polygons, from the corridor's start, that lie behind an agent at
    /// that corner.
    [[nodiscard]] std::span<const std::uint32_t> passed() const { return passed_; }

    [[nodiscard]] std::size_t bytes() const;

  private:
    struct KnownPolygon {
        float cost = 0.0F;
        std::uint32_t from = 0;
        std::uint32_t search = 0;
        Vec3 entry = Vec3::Zero();  ///< point where it was entered
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
