// DetourMesh: the peer for paths on grids, Detour on a navmesh that Recast builds from the map.
#pragma once

#include "server/ai/pathfinding/grid/grid_map.h"
#include "server/ai/pathfinding/navmesh/navmesh.h"

#include <cstddef>
#include <memory>

namespace zoned::bench {

/// A cell of the map is a cell of Recast's heightfield, and agents have no width. The other
/// settings are those of Recast's demonstration. Watershed regions have at least 8 cells and are
/// merged up to 20. Contours are simplified by up to 1.3 cells, and polygons have six corners.
/// (Closer contours make two to three times as many polygons, and queries slower by the same
/// factor.)
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
