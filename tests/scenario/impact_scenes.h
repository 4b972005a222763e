// ImpactScenes: described scenes of impacts that chain, and of plates that lean on each other.
#pragma once

#include "tests/scenario/physics_scenes.h"

namespace zoned::scenario {

/// S15: `count` balls in a row with `gap` m between them, the first at kRowSpeed, no gravity.
Description row_of_balls(int count, double gap, double restitution);
inline constexpr double kRowSpeed = 2.0;  ///< m/s

/// S15: five balls that touch, each on a rod of 3 m; the first is lifted by 40 degrees, 20 s.
Description cradle();

/// S15: a ball at 5 m/s breaks a triangle of 15, a tenth of a millimetre apart; no gravity.
Description billiard_break(double restitution);

/// S16, with the numbers that its variants change.
struct CardHouse {
    double friction = 0.7;
    double half_thickness = 0.01;  ///< of a plate, m
    double x = 0.0;                ///< of the middle of the house, m
    double dt = 1.0 / 60.0;        ///< s
};

/// S16: five storeys of plates that lean in pairs, with plates across, 20 s.
Description house_of_cards(const CardHouse& house);

}  // namespace zoned::scenario
