// Constraints: one distance constraint of a soft body, by extended position-based dynamics.
// Reached by no program yet: soft bodies on a device will use it.
#pragma once

#include "kernels/include/kernel_base.h"

ZK_BEGIN

/// Two nodes that are to be `rest` metres apart. Compliance is the inverse of stiffness, m/N.
typedef struct DistanceLink {
    int a, b;
    float rest;
    float compliance;
} DistanceLink;

/// Macklin, Mueller, Chentanez, "XPBD: position-based simulation of compliant constrained
/// dynamics", MIG 2016, equation 18, for the constraint |a - b| - rest. `softness` is compliance /
/// h^2, `wa` and `wb` the inverse masses (0: held). In and out: positions of both, lambda. Two held
/// nodes, and two in one place, have no direction to go and stay.
ZK_REAL_FN void constraint_solve(Real* ax,
                                 Real* ay,
                                 Real* az,
                                 const Real wa,
                                 Real* bx,
                                 Real* by,
                                 Real* bz,
                                 const Real wb,
                                 const Real rest,
                                 const Real softness,
                                 Real* lambda) {
    const Real zero = zk_splat(0.0f);
    const Real dx = *ax - *bx;
    const Real dy = *ay - *by;
    const Real dz = *az - *bz;
    const Real length = zk_sqrt(dx * dx + dy * dy + dz * dz);
    const Real w = wa + wb;
    const ZK_MASK can = (length > 0.0f) & (w > 0.0f);
    const Real step = zk_pick(can, (rest - length - softness * *lambda) / (w + softness), zero);
    const Real along = zk_pick(can, step / length, zero);
    *lambda = *lambda + step;
    *ax = *ax + wa * along * dx;
    *ay = *ay + wa * along * dy;
    *az = *az + wa * along * dz;
    *bx = *bx - wb * along * dx;
    *by = *by - wb * along * dy;
    *bz = *bz - wb * along * dz;
}

ZK_END
