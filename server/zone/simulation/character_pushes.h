// Character pushes: bodies that hit an agent's character knock it on.
#pragma once

#include "server/zone/zone_state.h"

namespace zoned::zone {

/// Characters are kinematic for the physics: bodies rebound from them as from a wall. This gives a
/// character that nobody plays its share of the impulse, as if two free bodies parted. A body of
/// mass m that comes at speed v along the normal gives J / (M + m) to a character of mass M. The
/// share is never more speed than the body came with, nor more than the type's
/// max_velocity_jump_mps. The character's own motion into the contact (it walks into a crate)
/// pushes the body alone.
///
/// The knock is a velocity from which the next movement pass starts. That pass is swept, so nobody
/// is pushed through anything. Avatars are left alone: their clients could not foresee it. Runs
/// between Scene::step and copy_moved_bodies: entities' velocities are those before the step.
/// Returns how many were pushed. A body of a neighbour zone pushes from when this zone owns it.
std::uint32_t push_characters(ZoneState& state);

}  // namespace zoned::zone
