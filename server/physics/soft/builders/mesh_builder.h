// Mesh builder: a soft body from a surface of triangles.
#pragma once

#include "server/physics/soft/soft_def.h"
#include "shared/core/result.h"

#include <cstddef>
#include <cstdint>
#include <vector>

namespace zoned::physics::soft {

/// Vertices of a mesh within it are pinned.
struct MeshPin {
    Vec3 centre = Vec3::Zero();  ///< m
    float radius = 0.05F;        ///< m
};

/// A surface of triangles, open (cloth) or closed (with gas within, or none). Vertices at the same
/// place are one. Each triangle hands a third of its share of the mass, by area, to each corner.
/// An edge is a structural spring of stiffness x (area of the triangles at it) / (its length)^2: so
/// the sheet is as stiff however it is cut into triangles (A. Van Gelder, "Approximate simulation
/// of elastic membranes by triangulated spring meshes", 1998). A grid of squares, each cut in two,
/// gets the springs of a cloth of this stiffness, and half of it along its diagonals. A bend spring
/// goes across each inner edge, from one opposite corner to the other, by the same rule, at most
/// bend_stiffness.
struct MeshBodyDef {
    std::vector<Vec3> vertices;  ///< m
    /// Three for each triangle, counter-clockwise seen from outside.
    std::vector<std::uint32_t> indices;
    /// Lines of a file in which the triangles stand, for messages; empty: messages count triangles
    /// from 0.
    std::vector<std::uint32_t> lines;
    float weld = 0.0F;             ///< vertices no farther apart are one, m; see MeshOptions
    float mass = 1.0F;             ///< of the whole, kg
    float stiffness = 1.0e4F;      ///< N/m
    float bend_stiffness = 10.0F;  ///< N/m; 0: none
    /// Of a spring between nodes of the mesh; of nodes that stand for several as much as those had.
    float damping_share = 0.1F;
    float gas_pressure = 0.0F;  ///< absolute, Pa; 0: none. The surface must be closed then
    std::vector<MeshPin> pins;
    /// Simulates at most so many of the vertices, the rest hang on them; 0: all. Pinned ones stay
    /// nodes. See simplify_mesh for which, and for their triangles. The masses of the others go to
    /// the corners of the triangle on which they hang, then all are changed by the least that keeps
    /// the centre of mass.
    int nodes = 0;
};

inline constexpr std::size_t kMostMeshVertices = 65536;  ///< of a MeshBodyDef, welded

/// A definition that may be changed further, or the mistake with its place. Refused: numbers out of
/// range, a triangle without area or twice there, an edge of more than two triangles, several parts
/// that nothing joins, a pin that holds no vertex, more vertices than kMostMeshVertices, fewer
/// nodes than the mesh can be drawn together to; with gas also open edges, neighbours that face in
/// opposite directions, and a surface that faces inward.
core::Result<SoftDef> build_mesh_body(const MeshBodyDef& def);

}  // namespace zoned::physics::soft
