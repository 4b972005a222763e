// ContactBatch: eight contacts that share no moving body, laid out for the wide solver.
#pragma once

#include "server/physics/simd/lanes.h"

#include <cstdint>

namespace zoned::physics {

/// One contact point of each of eight contacts. Lanes that have no such point have mass 0.
struct PointLanes {
    Lanes3 arm;                      ///< from a's centre, m, world axes, at the time of contact
    Lanes separation = lanes(1.0F);  ///< m, at the time of contact
    Lanes mass{};                    ///< effective, kg
    Lanes impulse{};                 ///< N s in this substep
    Lanes total{};                   ///< N s in this step
    Lanes lever{};                   ///< distance from where friction acts, m
};

/// Where the change of speed at point j by an impulse at point k stands among those of a contact:
/// the lower triangle, row by row.
constexpr std::size_t coupling_of(std::size_t j, std::size_t k) {
    return j > k ? j * (j + 1) / 2 + k : k * (k + 1) / 2 + j;
}

/// Resistance of eight contacts to rolling and spinning, which few contacts have.
struct RollLanes {
    Lanes rolling{}, spinning{};     ///< most moment per load, m
    Lanes roll1{}, roll2{}, spin{};  ///< about the tangents and the normal, N m s in this substep
};

struct ContactBatch {
    LaneRows a{}, b{};            ///< slots in SolverBodies; 0 in lanes that are not used
    LaneRows contact{};           ///< index in ContactGraph; kNoIndex in lanes that are not used
    std::uint32_t points = 0;     ///< first in the table of points
    std::uint32_t count = 0;      ///< most points of a lane
    std::uint32_t couplings = 0;  ///< first in the table of couplings
    std::uint32_t watched = 0;    ///< a bit for each lane that may see an impact
    std::uint32_t rolls = 0;      ///< 1 + place in the table of RollLanes; 0: nothing resists
    Lanes3 normal;                ///< from a to b
    Lanes3 tangent;               ///< the second one is normal x tangent
    Lanes3 between;    ///< a's arm minus b's: from a's centre to b's at the time of contact
    Lanes3 lead;       ///< how far b has to move relative to a until the contact, negated
    Lanes follow_b{};  ///< 1: the point of contact travels with b, 0: with a
    Lanes friction{};  ///< coefficient
    Lanes3 grip;       ///< arm from a's centre to where friction acts
    Lanes inv11{}, inv12{}, inv22{};  ///< inverse of the 2 x 2 friction mass
    Lanes twist_mass{};
    Lanes impulse1{}, impulse2{}, twist{};
    Lanes3 fitted;        ///< how far the bodies stood from there when the masses were computed
    Lanes same2{};        ///< up to this much, squared, the masses hold
    bool turns = false;   ///< a body's inertia follows it in each substep
    bool strays = false;  ///< in this substep the masses have to follow the bodies
    Lanes carried{};      ///< the recent impulse of each point, N s
};

}  // namespace zoned::physics
