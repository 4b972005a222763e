// Residual: the distance of a row system from its solution.
#pragma once

#include "server/physics/solver_variants/rows/row_system.h"

namespace zoned::physics {

/// Root mean square over the rows of the natural map of the complementarity problem in m/s,
/// d (lambda - P(lambda - w / d)), with d the row's response + soft and P the projection onto its
/// bounds (F. Facchinei, J.-S. Pang, "Finite-Dimensional Variational Inequalities and
/// Complementarity Problems", 2003, section 1.5): |w| where a row is free, zero where it rests at a
/// bound that it presses against, and zero for all rows exactly at a solution. 0 without rows.
double residual(const RowSystem& system);

/// The same for some of the rows.
double residual(const RowSystem& system, const RowGroup& group);

}  // namespace zoned::physics
