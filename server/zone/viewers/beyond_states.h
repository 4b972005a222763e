// mark_beyond_states: entities whose position states cannot tell.
#pragma once

#include "server/zone/zone_state.h"

namespace zoned::zone {

/// Sets and clears kBeyond: a state holds positions within the extents of its quantisation, and a
/// body that was thrown or slides on for ever is outside of them at some time. Looks at what moves
/// or was touched.
void mark_beyond_states(ZoneState& state);

}  // namespace zoned::zone
