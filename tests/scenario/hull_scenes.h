// HullScenes: described scenes of hulls, compounds and surfaces, and of a million static boxes.
#pragma once

#include "tests/scenario/physics_scenes.h"

namespace zoned::scenario {

/// S17: `count` hulls of 24 random points fall through a cone onto a surface.
Description hull_funnel(int count);

/// S17: `count` compound trees of 22 hexagonal prisms each roll down a surface.
Description rolling_trees(int count);

/// S17: side x 4 x side boxes, balls, capsules and pyramids fall on a surface.
Description mixed_on_mesh(int side);

/// S18: side x side static boxes end to end, a hundred balls dropped on them; one of them rolls on
/// for ever.
Description static_field(int side);

}  // namespace zoned::scenario
