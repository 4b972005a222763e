// ZonedScene: a described scene as one of our engine's.
#pragma once

#include "server/physics/scene/scene.h"
#include "tests/scenario/physics_scenes.h"

#include <string>
#include <vector>

namespace zoned::bench {

struct ZonedScene {
    physics::Scene scene;
    std::vector<zoned::BodyId> ids;  ///< by index in the description
    /// The engine's axes of each body in those of the description.
    std::vector<physics::Frame> frames;
    float dt = 0.0F;  ///< s
};

/// Gravity and sleeping come from the description, all else from `settings`. Throws where the
/// engine refuses a body or joint.
ZonedScene build_scene(const scenario::Description& description, physics::PhysicsSettings settings);

/// The methods besides the default by the names of their rows, with their settings.
struct NamedMethod {
    std::string name;
    physics::SolverVariant method;
    physics::ManifoldMode manifold = physics::ManifoldMode::kPoints;
};

std::vector<NamedMethod> contact_methods();

}  // namespace zoned::bench
