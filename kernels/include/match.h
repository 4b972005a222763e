// Match: which entities a viewer hears of, by aura and nimbus.
#pragma once

#include "kernels/include/flock.h"

ZK_BEGIN

/// A viewer hears of an entity when their horizontal distance is at most the smaller of the
/// viewer's nimbus and the entity's aura, closed; a radius that is not positive hears nothing.
typedef struct MatchViewer {
    float x, z;
    float nimbus;  // m
} MatchViewer;

ZK_REAL_FN ZK_MASK match_hears(const Real dx, const Real dz, const Real aura, const Real nimbus) {
    const Real r = zk_pick(aura < nimbus, aura, nimbus);
    return (r > 0.0f) & (dx * dx + dz * dz <= r * r);
}

ZK_END
