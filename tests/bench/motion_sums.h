// MotionSums: energy and momentum of a scene's bodies, and the errors of its joints, as motions
// tell.
#pragma once

#include "tests/bench/simulator.h"
#include "tests/scenario/physics_scenes.h"

namespace zoned::bench {

bool is_finite(const Motion& motion);

/// Kinetic energy, J.
double kinetic_energy(const scenario::Body& body, const Motion& motion);

struct MotionSums {
    double kinetic = 0.0;            ///< J
    double potential = 0.0;          ///< J, zero at the world's origin
    Vec3d momentum = Vec3d::Zero();  ///< kg m/s
    double momentum_size = 0.0;      ///< sum of the sizes of its terms, kg m/s
    double fastest = 0.0;            ///< m/s
    int not_finite = 0;              ///< bodies, which the sums leave out
};

/// Of all bodies that move; `now` at their present motions.
MotionSums sums_at_start(const scenario::Description& description);
MotionSums sums_now(const scenario::Description& description, const Simulator& simulator);

struct JointErrors {
    double gap_m = 0.0;     ///< largest distance of two points that a joint holds together
    double axis_rad = 0.0;  ///< largest angle between the two axes of a hinge
};

/// Infinite where a body is not finite.
JointErrors joint_errors(const scenario::Description& description, const Simulator& simulator);

}  // namespace zoned::bench
