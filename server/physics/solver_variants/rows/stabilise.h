// Stabilisation: the bias and softness by which rows undo overlaps and the gaps of joints.
#pragma once

#include "server/physics/settings/variant_settings.h"
#include "server/physics/solver_variants/rows/row_system.h"

namespace zoned::physics {

/// From RowSystem::gap to `bias` and `soft` of a normal row, for a solve over h seconds. A gap may
/// close as far as the surface. An overlap C is undone
/// - by Baumgarte's bias, beta C / h (J. Baumgarte, Comp. Meth. Appl. Mech. Eng. 1, 1972): a single
///   row's error is multiplied by 1 - beta in each solve, which is stable for beta in (0, 2) and
///   free of swinging up to 1;
/// - as a spring and damper, integrated implicitly (E. Catto, "Soft Constraints", GDC 2011): with
///   w = 2 pi hz and m the effective mass, k = m w^2 and c = 2 m zeta w, soft = 1 / (h (c + h k))
///   and bias = C h k soft;
/// - not by this row at all, where positions are corrected apart (kSplit).
void stabilise_contact(const VariantSettings& settings,
                       double h,
                       std::size_t row,
                       RowSystem& system);

/// The same for an error C of either sign, in a row that holds it at zero or, with `limit`, above.
void stabilise_joint(const VariantSettings& settings,
                     double h,
                     bool limit,
                     std::size_t row,
                     RowSystem& system);

/// The bias of the pass that corrects positions alone (kSplit), for rows that undo errors; others
/// are left out by bounds of zero. Velocities in `system` must be zero.
void ask_for_positions(const VariantSettings& settings, double h, RowSystem& system);

/// The change of the kinetic energy in a solve by rows that undo errors, J.
struct BiasEnergy {
    double in = 0.0;
    double out = 0.0;
};

/// Velocities are linear in the impulses. So a row's impulse does the work lambda (w_before +
/// w_after) / 2 with the row's speeds before and after all impulses. These sum up to the change of
/// the kinetic energy exactly. Sums the work of the rows that undo errors, by sign. `before`: J V
/// of all rows without their impulses.
BiasEnergy bias_energy(const RowSystem& system, std::span<const double> before);

}  // namespace zoned::physics
