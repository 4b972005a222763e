// Copy from physics: writes the moved bodies back into the shared columns, and their contacts to
// the rules.
#pragma once

#include "server/zone/zone_state.h"

namespace zoned::zone {

/// Copies the state of moved dynamic bodies into their entities' columns. Returns how many.
std::uint32_t copy_moved_bodies(ZoneState& state);

/// Hands the step's contacts to the rules and remembers which props touched a neighbour's ghost.
/// Returns how many.
std::uint32_t report_contacts(ZoneState& state, RulesContext& context);

}  // namespace zoned::zone
