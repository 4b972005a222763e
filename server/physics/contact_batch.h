// ContactBatch: eight contacts that share no moving body, laid out for the wide solver.
#pragma once

#include "server/physics/bodies.h"
#include "server/physics/lanes.h"

#include <cstdint>

namespace zoned::physics {

/// One contact point of each of eight contacts. Lanes that have no such point have mass 0.
struct PointLanes {
    Lanes3 arm;        ///< from a's centre, m, world axes, at the time of contact
    Lanes separation;  ///< m, at the time of contact
    Lanes mass;        ///< effective, kg
    Lanes impulse;     ///< N s in this substep
    Lanes total;       ///< N s in this step
    Lanes lever;       ///< distance from where friction acts, m

    static PointLanes none() {
        const Lanes zero = lanes(0.0F);
        return {{zero, zero, zero}, lanes(1.0F), zero, zero, zero, zero};
    }
};

struct ContactBatch {
    LaneRows a{}, b{};         ///< slots in SolverBodies; 0 in lanes that are not used
    LaneRows contact{};        ///< index in ContactGraph; kNoIndex in lanes that are not used
    std::uint32_t points = 0;  ///< first in the table of points
    std::uint32_t count = 0;   ///< most points of a lane
    Lanes3 normal;             ///< from a to b
    Lanes3 tangent;            ///< the second one is normal x tangent
    Lanes3 between;            ///< a's arm minus b's: from a's centre to b's at the time of contact
    Lanes3 lead;               ///< how far b has to move relative to a until the contact, negated
    Lanes follow_b;            ///< 1: the point of contact travels with b, 0: with a
    Lanes friction;            ///< coefficient
    Lanes3 grip;               ///< arm from a's centre to where friction acts
    Lanes inv11, inv12, inv22;  ///< inverse of the 2 x 2 friction mass
    Lanes twist_mass;
    Lanes impulse1, impulse2, twist;

    static ContactBatch none() {
        const Lanes zero = lanes(0.0F);
        const Lanes3 zero3{zero, zero, zero};
        ContactBatch batch{{},
                           {},
                           {},
                           0,
                           0,
                           zero3,
                           zero3,
                           zero3,
                           zero3,
                           zero,
                           zero,
                           zero3,
                           zero,
                           zero,
                           zero,
                           zero,
                           zero,
                           zero,
                           zero};
        batch.contact.fill(kNoIndex);
        return batch;
    }
};

}  // namespace zoned::physics
