// ClothScene: a falling cloth, described apart from any engine, and its reference solution.
#pragma once

#include "shared/math/types.h"

#include <vector>

namespace zoned::scenario {

/// nodes x nodes on a level square, pinned at the two corners (0, 0) and (nodes - 1, 0), all of the
/// same mass, released at rest. Springs: structural along both axes, shear along both diagonals of
/// each cell with half the stiffness, bend to the next node but one with a tenth.
struct Cloth {
    int nodes = 64;          ///< along each side
    double size = 2.0;       ///< of a side, m
    double density = 0.2;    ///< kg/m2
    double stiffness = 1e4;  ///< structural, N/m
    double gravity = 9.81;   ///< m/s2
    double dt = 1.0 / 60.0;  ///< s
    /// Air, as a force against the velocity: v' = -drag v, 1/s. Cloth of 0.2 kg/m2 falls flat at
    /// below 2 m/s, which would be 5 1/s. A value of 2 1/s is that of cloth that falls partly along
    /// itself.
    double drag = 2.0;
    /// Damping of each spring as a share of the critical damping of two nodes on it: c = 2 share
    /// sqrt(k m / 2), N s/m.
    double damping_share = 0.2;

    [[nodiscard]] double node_mass() const { return density * size * size / (nodes * nodes); }

    [[nodiscard]] int count() const { return nodes * nodes; }
};

/// A spring from a node to the node that lies (di, dj) ahead in the lattice.
struct ClothSprings {
    int di = 1;
    int dj = 0;
    double stiffness = 0.0;  ///< N/m
    double damping = 0.0;    ///< N s/m
    double rest = 0.0;       ///< m
};

std::vector<ClothSprings> cloth_springs(const Cloth& cloth);

inline constexpr double kClothSettleDrag = 5.0;  ///< 1/s: of the run that ends at rest
inline constexpr double kClothRestTime = 6.0;    ///< s: how long that run takes

/// Node positions, row by row along x, after `seconds`. The leapfrog method runs in doubles with
/// steps of 1 / (pace w) s, where w bounds the highest frequency of the springs. Without damping it
/// is stable from a pace of 0.5 on; damping asks for a little more. A pace of 1 is dt/151 for
/// springs of 10^3 N/m and dt/4770 for 10^6.
std::vector<Vec3d> cloth_reference(const Cloth& cloth, double seconds, double pace);

/// Mean distance of nodes, m.
double mean_distance(const std::vector<Vec3d>& a, const std::vector<Vec3d>& b);

}  // namespace zoned::scenario
