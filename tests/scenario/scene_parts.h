// SceneParts: the bodies that described scenes are put together from.
#pragma once

#include "tests/scenario/physics_scenes.h"

namespace zoned::scenario {

/// A static box of this full size.
Body fixed_box(const Vec3d& size, const Vec3d& middle, double friction, double restitution);

/// A static box whose top is y = 0, `width` wide along x and z.
Body ground(double width, double friction, double restitution = 0.0);

/// A body at rest.
Body at(const Solid& solid, double mass, const Vec3d& position, double friction);

}  // namespace zoned::scenario
