// MeshVisibility: lengths of the shortest paths on a mesh, the reference for near-best ones.
#pragma once

#include "server/ai/pathfinding/navmesh/navmesh.h"

#include <cstddef>
#include <cstdint>
#include <vector>

namespace zoned::bench {

/// On level ground shortest paths turn only at corners of the mesh (Lozano-Perez and Wesley, "An
/// algorithm for planning collision-free paths among polyhedral obstacles", Communications of the
/// ACM 22, 1979). So this is Dijkstra over the visibility graph, with visibility given by
/// Navmesh::walk(). Slow.
class MeshVisibility {
  public:
    explicit MeshVisibility(const ai::pathfinding::Navmesh& mesh);

    /// Below 0 where there is no path. `reach_m` as of NavmeshSearch::plan().
    double shortest(const Vec3& from, const Vec3& to, float reach_m);

  private:
    struct Seen {
        std::uint32_t vertex;
        double length;
    };

    /// Whether a straight line leads from a place on a polygon to another.
    [[nodiscard]] bool sees(std::uint32_t polygon, const Vec3& from, const Vec3& to) const;
    [[nodiscard]] std::vector<Seen> seen_from(std::uint32_t polygon, const Vec3& place) const;

    const ai::pathfinding::Navmesh& mesh_;
    std::vector<std::uint32_t> turning_;                // vertices at the edge of the mesh
    std::vector<std::vector<std::uint32_t>> polygons_;  // of each vertex
    std::vector<std::vector<Seen>> seen_;               // by vertex
};

}  // namespace zoned::bench
