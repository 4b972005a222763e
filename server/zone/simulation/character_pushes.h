// Pushes: bodies that hit characters with agents knock them on.
#pragma once

#include "server/zone/zone_state.h"

namespace zoned::zone {

/// Characters are kinematic for the physics, which lets bodies rebound from them as from a wall.
/// This gives a character that nobody plays its share of the impulse: of a body of mass m that
/// comes at speed v along the normal, J / (M + m) for a character of mass M, as two free bodies
/// would part it, but never more speed than the body came with, nor than the type's
/// max_velocity_jump_mps. What the character itself brings to the contact (it walks into a crate)
/// pushes the body alone. The knock is a velocity that the next movement pass starts from: swept,
/// so that nobody is pushed through anything. Avatars are left alone: their clients could not
/// foresee it. Between Scene::step and copy_moved_bodies: entities' velocities are those before the
/// step. Returns how many were pushed. A body of a neighbour zone pushes from when this zone owns
/// it.
std::uint32_t push_characters(ZoneState& state);

}  // namespace zoned::zone
