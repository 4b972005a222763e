// DetourMesh: the peer for paths on grids, Detour on a navmesh that Recast builds from the map.
#pragma once

#include "server/ai/pathfinding/grid/grid_map.h"
#include "server/ai/pathfinding/navmesh/navmesh.h"

#include <cstddef>
#include <memory>

namespace zoned::bench {

/// A cell of the map is a cell of Recast's heightfield, and agents have no width. All else is as in
/// Recast's demonstration: watershed regions of at least 8 cells, merged up to 20, contours
/// simplified by up to 1.3 cells, polygons of six corners. (Closer contours make meshes of two to
/// three times the polygons, and queries slower by the same factor.)
class DetourMesh {
  public:
    /// Nothing where Recast can't build it.
    static std::unique_ptr<DetourMesh> bake(const ai::pathfinding::GridMap& map);
    ~DetourMesh();
    DetourMesh(const DetourMesh&) = delete;
    DetourMesh& operator=(const DetourMesh&) = delete;

    /// From centre to centre: finds the nearest polygons, the corridor, and the corners of the
    /// string pulled straight through it. Returns the length of that path, below 0 where there is
    /// none.
    double find(ai::pathfinding::Cell start, ai::pathfinding::Cell goal);

    /// The very same polygons, for our own search.
    [[nodiscard]] const ai::pathfinding::Navmesh& navmesh() const;

    [[nodiscard]] std::size_t bytes() const;
    [[nodiscard]] int polygons() const;

  private:
    struct Mesh;
    explicit DetourMesh(std::unique_ptr<Mesh> mesh);
    std::unique_ptr<Mesh> mesh_;
};

}  // namespace zoned::bench
