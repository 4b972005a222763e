// Type body: an entity type as the physics sees it.
#pragma once

#include "server/physics/shapes/shape.h"
#include "server/world/entity_type.h"

namespace zoned::zone {

/// The body that an owned entity of the type has: shape, material, mass and kind (dynamic for
/// props, kinematic for characters), at rest at the origin.
physics::BodyDef body_of(const world::EntityType& type);

}  // namespace zoned::zone
