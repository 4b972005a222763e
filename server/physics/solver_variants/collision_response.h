// Collision response: the methods that are not a solve: collisions one by one, and springs.
#pragma once

#include "server/physics/settings/variant_settings.h"
#include "server/physics/solver_variants/rows/row_system.h"

namespace zoned::physics {

/// Sequential collision impulses (B. Mirtich, J. Canny, "Impulse-based simulation of rigid bodies",
/// I3D 1995; E. Guendelman, R. Bridson, R. Fedkiw, "Nonconvex rigid bodies with stacking", SIGGRAPH
/// 2003). A normal row that closes is a collision of its own with the restitution of its materials,
/// j = -(1 + e) w / (J M^-1 J^T), linear and angular. Impulses push and are never taken back. A
/// body set going by a collision may collide again in the same step, so that a row of spheres hands
/// an impact on. Friction follows each collision, bounded by the impulse that the point has carried
/// in the step. Joints are rows as in Gauss-Seidel. `h`: length of the substep, s. Ends after
/// `passes` or when nothing closes; returns the passes done.
int respond_by_impulses(RowSystem& system, double h, double restitution_speed, int passes);

/// The longest stable substep of a spring with angular frequency w and damping ratio zeta as a
/// multiple of 1 / w: 2 (sqrt(1 + zeta^2) - zeta), from the roots of the substep's matrix
/// z^2 - (2 - 2 zeta w h - (w h)^2) z + (1 - 2 zeta w h) by Jury's conditions; 2 without damping.
/// This is semi-implicit Euler's. Velocity Verlet with the damping at the velocities that are known
/// has (w h)^2 < 4 (1 + (1 - c)^2) / (2 - c), c = zeta w h: the same without damping, and wider
/// with any.
double penalty_limit(double damping_ratio);

/// Springs and dampers along normal rows that overlap, and along the rows of joints, push over
/// `seconds` of a substep of h. With m = 1 / `split` of a row - the body's mass shared by its rows
/// - k = m w^2 and c = 2 m zeta w, w = penalty_share x penalty_limit / h. As J M^-1 J^T <= split,
/// no mode of all the springs together is faster than w, and the whole is stable for a share below
/// 1. Contacts never pull. Friction is a spring of the same stiffness that slides at the
/// coefficient times the load (P. Cundall, O. Strack, Geotechnique 29, 1979). Its force is the
/// row's first guess; afterwards `lambda` holds its sum over the substep.
void respond_by_penalties(const VariantSettings& settings,
                          double h,
                          double seconds,
                          RowSystem& system);

}  // namespace zoned::physics
