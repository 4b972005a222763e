// Ray: where a ray meets solids, exactly and in double precision; judges engines, uses none.
#pragma once

#include "tests/scenario/physics_scenes.h"

#include <span>

namespace zoned::scenario {

struct Ray {
    Vec3d origin = Vec3d::Zero();
    Vec3d direction = Vec3d::UnitX();  ///< unit length
    double length = 1.0;               ///< m
};

/// Distance along the ray to the solid's surface, metres; 0 from inside; infinity for a miss.
double ray_distance(const Ray& ray, const Solid& solid, const Pose& pose);

/// The least distance over all bodies, each tested in turn; infinity for a miss.
double ray_distance(const Ray& ray, std::span<const Body> bodies);

}  // namespace zoned::scenario
