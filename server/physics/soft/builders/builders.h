// Builders of soft bodies: rope, cloth, jelly, balloon.
#pragma once

#include "server/physics/soft/soft_def.h"
#include "shared/core/result.h"

namespace zoned::physics::soft {

/// Springs' damping is given as a share of the critical one of a spring between two nodes of the
/// mass m: c = 2 share sqrt(k m / 2).
struct RopeDef {
    Vec3 from = Vec3::Zero();      ///< first node, m
    Vec3 to = Vec3::UnitX();       ///< last node, m
    int nodes = 16;                ///< >= 2
    float mass = 1.0F;             ///< of the whole, kg
    float stiffness = 1.0e4F;      ///< of each spring between neighbours, N/m
    float bend_stiffness = 10.0F;  ///< of springs between a node and the next but one, N/m; 0: none
    float damping_share = 0.1F;
    bool pin_from = true;
    bool pin_to = false;
};

/// A level rectangle: x = origin + i, z = origin + j. Structural springs along both axes, shear
/// springs along both diagonals of each cell, bend springs from each node to the next but one.
struct ClothDef {
    Vec3 origin = Vec3::Zero();      ///< node (0, 0), m
    float size_x = 1.0F;             ///< m
    float size_z = 1.0F;             ///< m
    int nx = 16;                     ///< nodes along x, >= 2
    int nz = 16;                     ///< nodes along z, >= 2
    float density = 0.2F;            ///< kg/m2; all nodes have the same mass
    float stiffness = 1.0e4F;        ///< structural, N/m
    float shear_stiffness = 5.0e3F;  ///< N/m
    float bend_stiffness = 1.0e3F;   ///< N/m
    float damping_share = 0.1F;
    std::vector<std::array<int, 2>> pins;  ///< (i, j)
    /// Simulates a lattice that is coarser by this factor. Its nodes and springs stand for those of
    /// the fine one (masses and stiffness by its hat functions), and the nx nz nodes hang on it as
    /// vertices. It must divide nx - 1 and nz - 1, and pins must lie on the coarse lattice. 0: the
    /// largest such factor that leaves at least kEnoughCells cells along the shorter side. Cloth
    /// that tears wants 1: a vertex cannot hang on both sides of a cut.
    int coarsen = 0;
};

/// The lattice that `coarsen` 0 leaves: the mean error of a hanging cloth is then below 1 % of its
/// size (suite `soft` of the benchmark).
inline constexpr int kEnoughCells = 20;

/// A box lattice of nodes: springs along edges and diagonals of faces, five tetrahedra per cell.
struct JellyDef {
    Vec3 centre = Vec3::Zero();
    Vec3 size = Vec3::Ones();           ///< m
    std::array<int, 3> nodes{4, 4, 4};  ///< >= 2 each
    float mass = 1.0F;                  ///< kg
    float stiffness = 1.0e3F;           ///< N/m
    float damping_share = 0.1F;
    float bulk_modulus = 1.0e5F;  ///< Pa
    /// Hangs this many drawn vertices along each side of each face on the lattice; 0: none.
    int drawn = 0;
};

/// A sphere of triangles (icosahedron, each split `splits` times) filled with gas.
struct BalloonDef {
    Vec3 centre = Vec3::Zero();
    float radius = 0.5F;       ///< m
    int splits = 3;            ///< 0..6
    float mass = 0.2F;         ///< kg
    float stiffness = 1.0e3F;  ///< N/m
    float damping_share = 0.1F;
    float gas_pressure = 1.013e5F;  ///< absolute, Pa
};

/// Each gives a definition that may be changed further, or the mistake.
core::Result<SoftDef> build_rope(const RopeDef& def);
core::Result<SoftDef> build_cloth(const ClothDef& def);
core::Result<SoftDef> build_jelly(const JellyDef& def);
core::Result<SoftDef> build_balloon(const BalloonDef& def);

}  // namespace zoned::physics::soft
