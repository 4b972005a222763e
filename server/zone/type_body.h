// Type body: an entity type as the physics sees it.
#pragma once

#include "server/physics/shapes/shape.h"
#include "server/world/entity_type.h"

#include <span>

namespace zoned::zone {

/// The body that an owned entity of the type has: shape, material, mass and kind (dynamic for
/// props, kinematic for characters), at rest at the origin. `solids`: see ZoneSettings.
/// Of a soft type, whose entities have no rigid body: the box around it as it is defined.
physics::BodyDef body_of(const world::EntityType& type, std::span<const physics::Shape> solids);

}  // namespace zoned::zone
