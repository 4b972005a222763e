// Faults on purpose: what `testing.` settings make a zone do wrong, so that the verdict can be
// checked.
#pragma once

#include "server/zone/zone_state.h"

namespace zoned::zone {

/// True while this zone neither simulates nor publishes.
bool stalled(const ZoneState& state);

/// Hides the chosen entities from, and leaks a far one to, the viewers. Called between interest and
/// replication.
void corrupt_visibility(ZoneState& state);

/// Shifts the chosen entities' replicated position by the fault's offset (sign +1) and back (sign
/// -1).
void corrupt_positions(ZoneState& state, float sign);

}  // namespace zoned::zone
