// Recast owners: smart pointers that free Recast's structures.
#pragma once

#include <recastnavigation/Recast.h>

#include <memory>

namespace zoned::ai::pathfinding {

template <auto Free>
struct FreeRecast {
    template <class T>
    void operator()(T* p) const {
        Free(p);
    }
};

template <class T, auto Free>
using Recast = std::unique_ptr<T, FreeRecast<Free>>;

using RecastHeights = Recast<rcHeightfield, rcFreeHeightField>;
using RecastFloors = Recast<rcCompactHeightfield, rcFreeCompactHeightfield>;
using RecastContours = Recast<rcContourSet, rcFreeContourSet>;
using RecastPolygons = Recast<rcPolyMesh, rcFreePolyMesh>;
using RecastDetail = Recast<rcPolyMeshDetail, rcFreePolyMeshDetail>;

}  // namespace zoned::ai::pathfinding
