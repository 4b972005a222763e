// SceneGenerator: random scenes of every kind of thing that the rigid-body engine knows.
#pragma once

#include "tests/stability/random/random_scene.h"

#include <string>
#include <vector>

namespace zoned::stability {

/// Names of the families of things that scenes are mixed from.
std::vector<std::string> family_names();

/// Sound (why_unsound), and the same for the same two numbers. Families that a scene cannot hold
/// are left out: what hangs, lies or drives needs gravity and ground. `only` names families to
/// choose from; empty: all.
RandomScene generate_scene(std::uint64_t seed,
                           std::uint64_t index,
                           const std::vector<std::string>& only = {});

}  // namespace zoned::stability
