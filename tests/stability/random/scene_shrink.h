// SceneShrink: makes a failing scene as small as it gets while it still fails.
#pragma once

#include "tests/stability/random/random_scene.h"

#include <functional>

namespace zoned::stability {

/// Fewer bodies and joints, plainer ones, rounder numbers, a shorter time; sound throughout.
/// `fails` is true of `scene`, and of the result. Calls it at most `budget` times.
RandomScene shrink_scene(const RandomScene& scene,
                         const std::function<bool(const RandomScene&)>& fails,
                         int budget);

}  // namespace zoned::stability
