// Character movement: every owned character consumes one command; players' come from their input
// ring, the others' from ai.
#pragma once

#include "server/zone/zone_state.h"

namespace zoned::zone {

/// Fills the command column of players' avatars from the input rings and records missing commands.
void take_inputs(ZoneState& state);

/// Moves all owned characters by apply_input and gives their kinematic bodies the velocity that
/// leads them there within the step. Returns how many were moved (standing characters without a
/// command to move are skipped).
std::uint32_t move_characters(ZoneState& state);

/// True when a character at rest would move or turn by its command.
bool wants_to_move(const world::Entities& entities, world::Row row);

}  // namespace zoned::zone
