// PhysicsSceneList: the scenes of suite `physics`, with how each is measured.
#pragma once

#include "tests/bench/physics_meters.h"

#include <functional>
#include <string>
#include <vector>

namespace zoned::bench {

/// One described scene of a row.
struct PhysicsCase {
    std::string label;  ///< empty where the row has one case
    std::function<scenario::Description()> describe;
};

/// A row of the table: one scene, or several that differ in a number and run side by side. Such a
/// row gives the sum of their times, the error of the worst, and each one's as error_LABEL.
struct PhysicsScene {
    std::string name;
    std::string parameter;
    std::vector<PhysicsCase> cases;  ///< all with as many steps of the same length
    std::unique_ptr<Meter> (*meter)(const scenario::Description&);
    int quick_steps;       ///< length of a quick run
    int warm_up = 0;       ///< frames before timing starts
    bool variants = true;  ///< other methods than the default run without being asked for
    bool threads = true;   ///< false: one island, or all asleep, which two threads cannot share
};

/// `quick`: fewer bodies where a scene is large.
std::vector<PhysicsScene> physics_scenes(bool quick);

}  // namespace zoned::bench
