// Stability warnings: finds bodies that are too small, too fast, too stiff or too far out for the
// time step and the error budget.
#pragma once

#include "server/physics/scene/scene.h"

#include <string>
#include <vector>

namespace zoned::physics {

/// The rounding of a coordinate may take this share of the error budget.
inline constexpr float kRoundingShare = 0.1F;

/// How far out along an axis positions may lie, m: there floats are kRoundingShare of the budget
/// apart. A float of size x has neighbours x 2^-23 away at most.
inline float farthest_for(float error_budget_m) {
    return kRoundingShare * error_budget_m * 8388608.0F;
}

/// The properties of a body that the engine accepts but cannot simulate within the error budget in
/// steps of `dt` seconds: one sentence each, with the figures; empty when there is nothing to say.
/// Forces and contacts that come up later show in StepStats instead.
std::vector<std::string> stability_warnings_of(const BodyDef& def,
                                               const PhysicsSettings& settings,
                                               float dt);

/// The same of a joint between bodies of these masses, kg; 0: it holds one to the world.
std::vector<std::string> stability_warnings_of(const JointDef& def,
                                               float mass_a,
                                               float mass_b,
                                               const PhysicsSettings& settings,
                                               float dt);

/// The same of a heavy body on a light one, both resting on the ground in steps of `dt` seconds.
std::vector<std::string> stability_warnings_of_load(float light_kg,
                                                    float heavy_kg,
                                                    const PhysicsSettings& settings,
                                                    float dt);

/// And of the step itself.
std::vector<std::string> stability_warnings_of(const PhysicsSettings& settings, float dt);

}  // namespace zoned::physics
