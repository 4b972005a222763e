// Approaching props: finds props that are about to touch, so that a border between them can be
// cleared away before they do.
#pragma once

#include "server/zone/zone_state.h"

#include <vector>

namespace zoned::zone {

/// Two props belong into one zone this many ticks before they touch: one to be handed off, one for
/// two zones that hand at each other, and one to spare.
inline constexpr int kLookaheadTicks = 3;

/// True for a prop: owned, or the ghost of one.
bool is_prop(const ZoneState& state, world::Row row);

/// The rows of the props (ghosts or owned ones) that may touch `row`, a prop with a body, within
/// kLookaheadTicks if both go on as they move; ascending by body. By bounding spheres: some that
/// are listed will just pass by.
std::vector<world::Row> approached(const ZoneState& state, world::Row row, bool ghosts);

}  // namespace zoned::zone
