// Census: what a zone holds, as the ground for its plan, from counts that are kept and a look at
// what stirs.
#pragma once

#include "server/zone/zone_state.h"

namespace zoned::zone {

Census take_census(const ZoneState& state, std::size_t inbox_items);

}  // namespace zoned::zone
