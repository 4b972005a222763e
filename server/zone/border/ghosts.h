// Ghosts: read-only copies of neighbours' entities within the margin, exchanged each tick.
#pragma once

#include "server/zone/zone_state.h"

#include <span>

namespace zoned::zone {

/// Writes state.ghosts_out: owned, visible entities that lie within the margin of some other zone's
/// region. When nothing moved, came or went since the last export, the old one stays and
/// ghosts_out_changed is false.
void export_ghosts(ZoneState& state, bool something_changed);

/// Brings this zone's ghosts in line with the exports of all other zones: adds, updates, removes.
/// `zones` holds all zones; this zone's own export is skipped. Sets state.ghosts_moved. Returns the
/// number of ghosts.
std::uint32_t import_ghosts(ZoneState& state, std::span<ZoneState* const> zones);

}  // namespace zoned::zone
