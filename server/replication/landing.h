// Landing: finds where a falling entity comes to rest on static geometry, for its prediction.
#pragma once

#include "server/world/entity_type.h"
#include "shared/motion/kinematic_state.h"
#include "shared/motion/static_geometry.h"

namespace zoned::replication {

/// The height of the centre over a level floor on which the entity lies as it is turned, m. A box
/// lies on the side that looks down most.
float resting_height(const world::EntityType& type, const Quat& orientation);

/// Height of the centre where an entity that falls from `from` comes to rest (position, velocity;
/// acceleration is that of gravity). It is `height` over the topmost solid under its path that it
/// is above. The path is sampled in steps of a sixteenth of a second for three seconds; minus
/// infinity where it meets nothing by then. It is a guess for a prediction: sides of boxes, slopes
/// and moving solids are left out. A wrong guess costs a publication, never the bound.
float landing_height(const motion::StaticGeometry& ground,
                     const motion::KinematicState& from,
                     float height);

}  // namespace zoned::replication
