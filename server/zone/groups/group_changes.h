// Group changes: what a zone's rules are told of parties, matches and instances, and how that is
// hashed.
#pragma once

#include "server/zone/zone_state.h"

#include <cstdint>

namespace zoned::zone {

/// Whether tell_group_changes() has anything to tell.
[[nodiscard]] bool has_group_changes(const ZoneState& state);

/// Tells the rules of all that has changed since the last tick; instances that open or end are
/// filled and cleared. Returns how many changes.
std::uint32_t tell_group_changes(ZoneState& state, RulesContext& context);

/// Chains what has changed in this tick, in any zone.
void hash_groups(ZoneState& state);

}  // namespace zoned::zone
