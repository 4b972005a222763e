// JointScenes: described scenes of joints under contact: drops, a car, ragdolls, a sheet.
#pragma once

#include "tests/scenario/physics_scenes.h"

namespace zoned::scenario {

/// S11: a ball of 1000 kg fixed on one of 1000 / `ratio` kg, which begins this far above the
/// ground.
Description fixed_pair(double ratio);
inline constexpr double kPairDrop = 0.1;  ///< m

/// S11: a box of 1000 kg on four hinged balls of 1000 / `ratio` kg, dropped from `height` m.
Description wheeled_box(double ratio, double height);

/// S12: a car with a motor on each of four wheels, on a mesh or on a level box. From `seed` 1 on
/// each mass is off by up to 20 %.
Description car(bool mesh, int seed);
inline constexpr double kWheelSpeed = 20.0;    ///< of the motors, rad/s
inline constexpr double kWheelTorque = 400.0;  ///< most of each motor, N m
inline constexpr double kWheelRadius = 0.45;   ///< m

/// S13: one ragdoll above a level box, or `count` above a mesh, 25 to a layer.
Description ragdolls(int count);
inline constexpr std::size_t kRagdollParts = 11;

/// S14: side x side balls joined to their neighbours fall on a static ball.
Description sheet(int side);
inline constexpr double kSheetLink = 0.4;  ///< distance of neighbours, m

}  // namespace zoned::scenario
