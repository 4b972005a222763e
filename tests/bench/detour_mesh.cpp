#include "tests/bench/detour_mesh.h"

#include "server/ai/pathfinding/navmesh/recast_owned.h"

#include <recastnavigation/DetourCommon.h>
#include <recastnavigation/DetourNavMesh.h>
#include <recastnavigation/DetourNavMeshBuilder.h>
#include <recastnavigation/DetourNavMeshQuery.h>

#include <array>
#include <utility>

namespace zoned::bench {

namespace {

using ai::pathfinding::Cell;
using ai::pathfinding::GridMap;
using ai::pathfinding::Recast;
using ai::pathfinding::RecastContours;
using ai::pathfinding::RecastFloors;
using ai::pathfinding::RecastHeights;
using ai::pathfinding::RecastPolygons;

constexpr int kMostNodes = 65535;
constexpr int kMostPolygons = 4096;
constexpr int kMostCorners = 4096;
constexpr float kMaxError = 1.3F;
constexpr int kMinRegion = 8;
constexpr int kMergeRegion = 20;
constexpr int kVerticesPerPolygon = 6;
constexpr unsigned short kAgentHeight = 2;

/// Recast's polygons of the passable cells; null where it can't build them.
RecastPolygons polygons_of(const GridMap& map) {
    rcContext context(false);
    const RecastHeights field(rcAllocHeightfield());
    const RecastFloors compact(rcAllocCompactHeightfield());
    const RecastContours contours(rcAllocContourSet());
    RecastPolygons mesh(rcAllocPolyMesh());
    const std::array<float, 3> low{0.0F, 0.0F, 0.0F};
    const std::array<float, 3> high{
        static_cast<float>(map.width()), 4.0F, static_cast<float>(map.height())};
    if (!rcCreateHeightfield(
            &context, *field, map.width(), map.height(), low.data(), high.data(), 1.0F, 1.0F)) {
        return nullptr;
    }
    for (int y = 0; y < map.height(); ++y) {
        for (int x = 0; x < map.width(); ++x) {
            if (map.passable(Cell{static_cast<std::uint16_t>(x), static_cast<std::uint16_t>(y)})) {
                rcAddSpan(&context, *field, x, y, 0, 1, RC_WALKABLE_AREA, 1);
            }
        }
    }
    const bool built = rcBuildCompactHeightfield(&context, kAgentHeight, 1, *field, *compact) &&
                       rcBuildDistanceField(&context, *compact) &&
                       rcBuildRegions(&context, *compact, 0, kMinRegion, kMergeRegion) &&
                       rcBuildContours(&context, *compact, kMaxError, 0, *contours) &&
                       rcBuildPolyMesh(&context, *contours, kVerticesPerPolygon, *mesh);
    if (!built) {
        return nullptr;
    }
    for (int i = 0; i < mesh->npolys; ++i) {
        mesh->flags[i] = 1;
    }
    return mesh;
}

/// The same as polygons of ours.
ai::pathfinding::Navmesh navmesh_of(const rcPolyMesh& mesh) {
    using ai::pathfinding::Navmesh;
    std::vector<Vec3> vertices;
    std::vector<Navmesh::Polygon> polygons;
    for (int i = 0; i < mesh.nverts; ++i) {
        const unsigned short* v = mesh.verts + std::ptrdiff_t{3} * i;
        vertices.emplace_back(mesh.bmin[0] + mesh.cs * static_cast<float>(v[0]),
                              mesh.bmin[1] + mesh.ch * static_cast<float>(v[1]),
                              mesh.bmin[2] + mesh.cs * static_cast<float>(v[2]));
    }
    for (int i = 0; i < mesh.npolys; ++i) {
        const unsigned short* p = mesh.polys + std::ptrdiff_t{2} * kVerticesPerPolygon * i;
        Navmesh::Polygon polygon;
        for (int k = 0; k < kVerticesPerPolygon && p[k] != RC_MESH_NULL_IDX; ++k) {
            const unsigned short beyond = p[kVerticesPerPolygon + k];
            polygon.corners[static_cast<std::size_t>(k)] = p[k];
            polygon.neighbours[static_cast<std::size_t>(k)] =
                (beyond & 0x8000U) != 0 ? Navmesh::kNone : beyond;
            ++polygon.size;
        }
        polygons.push_back(polygon);
    }
    return Navmesh::of(std::move(vertices), std::move(polygons));
}

}  // namespace

struct DetourMesh::Mesh {
    Recast<dtNavMesh, dtFreeNavMesh> mesh{dtAllocNavMesh()};
    Recast<dtNavMeshQuery, dtFreeNavMeshQuery> query{dtAllocNavMeshQuery()};
    dtQueryFilter filter;
    ai::pathfinding::Navmesh ours;
    std::size_t bytes = 0;
    int polygons = 0;
    std::array<dtPolyRef, kMostPolygons> corridor{};
    std::array<float, 3 * kMostCorners> corners{};
};

DetourMesh::DetourMesh(std::unique_ptr<Mesh> mesh) : mesh_(std::move(mesh)) {
}

DetourMesh::~DetourMesh() = default;

std::unique_ptr<DetourMesh> DetourMesh::bake(const GridMap& map) {
    const auto polygons = polygons_of(map);
    if (!polygons) {
        return nullptr;
    }
    dtNavMeshCreateParams params{};
    params.verts = polygons->verts;
    params.vertCount = polygons->nverts;
    params.polys = polygons->polys;
    params.polyAreas = polygons->areas;
    params.polyFlags = polygons->flags;
    params.polyCount = polygons->npolys;
    params.nvp = polygons->nvp;
    params.walkableHeight = kAgentHeight;
    params.walkableClimb = 1.0F;
    dtVcopy(params.bmin, polygons->bmin);
    dtVcopy(params.bmax, polygons->bmax);
    params.cs = 1.0F;
    params.ch = 1.0F;
    params.buildBvTree = true;
    unsigned char* data = nullptr;
    int size = 0;
    auto made = std::make_unique<Mesh>();
    if (!dtCreateNavMeshData(&params, &data, &size)) {
        return nullptr;
    }
    if (dtStatusFailed(made->mesh->init(data, size, DT_TILE_FREE_DATA))) {
        dtFree(data);
        return nullptr;
    }
    if (dtStatusFailed(made->query->init(made->mesh.get(), kMostNodes))) {
        return nullptr;
    }
    made->bytes = static_cast<std::size_t>(size);
    made->polygons = polygons->npolys;
    made->ours = navmesh_of(*polygons);
    return std::unique_ptr<DetourMesh>(new DetourMesh(std::move(made)));
}

double DetourMesh::find(Cell start, Cell goal) {
    Mesh& m = *mesh_;
    const std::array<float, 3> half{1.0F, 2.0F, 1.0F};
    const auto centre = [](Cell c) {
        return std::array<float, 3>{
            static_cast<float>(c.x) + 0.5F, 1.0F, static_cast<float>(c.y) + 0.5F};
    };
    dtPolyRef first = 0;
    dtPolyRef last = 0;
    std::array<float, 3> from{};
    std::array<float, 3> to{};
    m.query->findNearestPoly(centre(start).data(), half.data(), &m.filter, &first, from.data());
    m.query->findNearestPoly(centre(goal).data(), half.data(), &m.filter, &last, to.data());
    if (first == 0 || last == 0) {
        return -1.0;
    }
    int polygons = 0;
    const dtStatus status = m.query->findPath(first,
                                              last,
                                              from.data(),
                                              to.data(),
                                              &m.filter,
                                              m.corridor.data(),
                                              &polygons,
                                              kMostPolygons);
    if (dtStatusFailed(status) || dtStatusDetail(status, DT_PARTIAL_RESULT)) {
        return -1.0;
    }
    int corners = 0;
    m.query->findStraightPath(from.data(),
                              to.data(),
                              m.corridor.data(),
                              polygons,
                              m.corners.data(),
                              nullptr,
                              nullptr,
                              &corners,
                              kMostCorners);
    double length = 0.0;
    for (int i = 1; i < corners; ++i) {
        const float* const at = m.corners.data() + std::ptrdiff_t{3} * i;
        length += static_cast<double>(dtVdist(at - 3, at));
    }
    return length;
}

const ai::pathfinding::Navmesh& DetourMesh::navmesh() const {
    return mesh_->ours;
}

std::size_t DetourMesh::bytes() const {
    return mesh_->bytes;
}

int DetourMesh::polygons() const {
    return mesh_->polygons;
}

}  // namespace zoned::bench
