// ExactImpacts: balls that fly freely and collide one pair at a time, event by event, in double.
#pragma once

#include "shared/math/types.h"

#include <span>
#include <vector>

namespace zoned::scenario {

/// A smooth ball without gravity.
struct FlyingBall {
    Vec3d position = Vec3d::Zero();  ///< m
    Vec3d velocity = Vec3d::Zero();  ///< m/s
    double radius = 0.5;             ///< m
    double mass = 1.0;               ///< kg
};

/// The balls after `seconds`. Each meeting of two balls is an event of its own, in the order in
/// which they meet: Newton's law with `restitution` along the line of centres. Balls that touch
/// count as a gap that closes at once. Pairs that close slower than 1e-10 m/s rest on each other.
/// (Alder, Wainwright, "Studies in molecular dynamics I", Journal of Chemical Physics 31, 1959.)
/// Throws where a million events do not end it.
std::vector<FlyingBall> fly(std::span<const FlyingBall> balls, double restitution, double seconds);

}  // namespace zoned::scenario
