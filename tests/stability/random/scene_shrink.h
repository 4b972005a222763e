// SceneShrink: makes a failing scene as small as it gets while it still fails.
#pragma once

#include "tests/stability/random/random_scene.h"

#include <functional>
#include <vector>

namespace zoned::stability {

/// A smallest subset of 0..count-1 that still fails, where no single element can be left out: the
/// minimising delta debugging of Zeller and Hildebrandt, "Simplifying and isolating
/// failure-inducing input", IEEE Trans. Software Eng. 28(2), 2002. `fails` gets ascending indices;
/// all of them together fail. It is called at most `budget` times, and `budget` counts down.
std::vector<std::size_t> minimise(std::size_t count,
                                  const std::function<bool(const std::vector<std::size_t>&)>& fails,
                                  int& budget);

/// Fewer bodies and joints, plainer ones, rounder numbers, a shorter time; sound throughout.
/// `fails` is true of `scene`, and of the result. Calls it at most `budget` times.
RandomScene shrink_scene(const RandomScene& scene,
                         const std::function<bool(const RandomScene&)>& fails,
                         int budget);

}  // namespace zoned::stability
