// Spring limit: the highest frequency of a soft body's nodes, and the substeps that explicit
// springs need for it.
#pragma once

#include "server/physics/soft/soft_body.h"

namespace zoned::physics::soft {

/// Upper bounds over all motions of the nodes: of the square of the angular frequency, and of the
/// rate at which dampers brake.
struct SpringLimit {
    double omega2 = 0.0;   ///< 1/s2
    double damping = 0.0;  ///< 1/s: the largest eigenvalue of M^-1 D

    [[nodiscard]] double omega() const;          ///< rad/s
    [[nodiscard]] double damping_ratio() const;  ///< damping / (2 omega)

    /// The longest stable substep of semi-implicit Euler, s; infinity: nothing swings.
    [[nodiscard]] double step_s() const;
};

/// The stiffness matrix is a sum over elements e of k_e g_e g_e^T: springs (g is the unit vector
/// along it at either end), volumes of tetrahedra (k = K / V, g their derivatives by the corners),
/// and the gas (k = p V / V^2). Each node's mass is dealt out to its elements in proportion to
/// s_ie = k_e |g_ie| G_e, G_e = sum over j of |g_je|; with S_i = sum over e of s_ie no eigenvalue
/// of the whole exceeds the largest of an element with its share of the masses,
///
///     omega^2 <= max over e of  sum over i of  |g_ie| / G_e  S_i / m_i
///
/// (Irons and Treharne, "A bound theorem in eigenvalues and its practical applications", 3rd Conf.
/// Matrix Methods in Structural Mechanics, 1971; Fried, "Bounds on the extremal eigenvalues of the
/// finite element stiffness and mass matrices and their spectral condition number", J. Sound Vib.
/// 22, 1972). A spring alone gives k (1/m_a + 1/m_b), which is exact; where many meet it lies below
/// Gershgorin's 2 sum k / m. Stretched springs are no stiffer across than along, so this holds
/// however springs lie and stretch; derivatives of volumes grow with the size, and are taken as if
/// all were longer by a quarter. The surplus pressure of gas turns forces as its surface turns:
/// Gershgorin's sum of that part is added. Dampers likewise with their c for k.
///
/// Semi-implicit Euler with both matrices is stable where h^2 omega^2 + 2 h damping <= 4 (from the
/// energy of its two-step form; for one spring that is Jury's criterion, see
/// semi_implicit_euler.h). A drag takes nothing off that: the nodes drift exactly, after the push.
SpringLimit spring_limit(SoftBody& body);
SpringLimit spring_limit(const SoftDef& def);

}  // namespace zoned::physics::soft
