// Mesh hanging: on which nodes of a simplified mesh each vertex of the whole one hangs.
#pragma once

#include "server/physics/soft/builders/mesh_simplifier.h"

#include <array>
#include <span>
#include <vector>

namespace zoned::physics::soft {

/// By vertex of the whole mesh.
struct HungMesh {
    std::vector<SoftVertex> vertices;
    /// The share of a vertex's mass that each of its first three nodes carries: 0..1, sum 1.
    std::vector<std::array<double, 3>> mass_shares;
};

/// A vertex that was kept hangs on itself. Another one hangs on the face nearest to it of those
/// around the vertex that it went to and its neighbours (a fold that lies nearer by chance is
/// another part of the surface), of equally near ones the first. Its place among the simplified
/// mesh's is exactly its own: barycentric in the plane of the face, and an offset along its normal.
/// Mass goes by the barycentric coordinates of the face's nearest point, which are never negative.
HungMesh hang_mesh(std::span<const Vec3> vertices, const SimplifiedMesh& coarse);

/// Changes masses by the least sum of (change)^2 / mass that brings their centre to `centre`; their
/// sum stays. False, and nothing changes, where a mass would lose more than nine tenths, or the
/// points lie in a plane that holds no such centre.
bool move_centre(std::span<const Vec3d> points, const Vec3d& centre, std::vector<double>& masses);

}  // namespace zoned::physics::soft
