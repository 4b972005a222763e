// SolidGeometry: polyhedra, compounds and surfaces of described scenes, in double precision.
#pragma once

#include "tests/scenario/physics_scenes.h"

#include <array>
#include <cstdint>
#include <span>
#include <vector>

namespace zoned::scenario {

/// A solid as a part of another one.
struct SolidPart {
    Solid solid;
    Pose pose;
};

/// A flat face of a polyhedron.
struct SolidFace {
    std::vector<std::uint32_t> ring;  ///< its corners, counter-clockwise seen from outside
    Vec3d normal = Vec3d::UnitY();    ///< unit, outwards
    double offset = 0.0;              ///< of its plane along the normal, m
};

/// An edge of a polyhedron with the two faces that meet there.
struct SolidEdge {
    std::array<std::uint32_t, 2> corners{};
    std::array<std::uint32_t, 2> faces{};
};

struct SolidGeometry {
    std::vector<Vec3d> points;     ///< corners of a hull or surface
    std::vector<SolidFace> faces;  ///< of a hull; of a surface its triangles, seen from the front
    std::vector<SolidEdge> edges;  ///< of a hull
    std::vector<SolidPart> parts;  ///< of a compound
    double radius = 0.0;           ///< of the ball about the centre that holds it, m
    double volume = 0.0;           ///< m3
    Vec3d inertia_per_mass = Vec3d::Zero();
    /// Surface: triangles by square cells of x and z, each cell's list between two `cell_starts`.
    double cell = 1.0;  ///< m
    std::array<int, 2> cell_lower{};
    std::array<int, 2> cell_counts{};
    std::vector<std::uint32_t> cell_starts;
    std::vector<std::uint32_t> cell_triangles;
};

struct BuiltSolid {
    Solid solid;
    /// Where the solid's centre and principal axes lie in the coordinates that it was built from.
    Pose pose;
};

/// The convex hull of a few points (time grows with the fourth power of their count), as a
/// solid of uniform density. Throws where they have no volume.
BuiltSolid solid_hull(std::span<const Vec3d> points);

/// Solids that move as one, of uniform density; a shared volume counts twice.
BuiltSolid solid_compound(std::span<const SolidPart> parts);

/// A one-sided surface, three indices a triangle, counter-clockwise seen from the front.
Solid solid_surface(std::vector<Vec3d> points, std::span<const std::uint32_t> indices);

/// The surface y = height(x, z) over cells of `cell` m, two right triangles each. It begins at
/// (lower_x, lower_z) and has `cells_x` by `cells_z` cells.
Solid solid_terrain(int cells_x,
                    int cells_z,
                    double cell,
                    double lower_x,
                    double lower_z,
                    double (*height)(double x, double z));

/// A box or hull as a polyhedron.
SolidGeometry polyhedron_of(const Solid& solid);

}  // namespace zoned::scenario
