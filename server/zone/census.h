// Census: counts what a zone holds, once per tick, as the ground for its plan.
#pragma once

#include "server/zone/zone_state.h"

namespace zoned::zone {

Census take_census(const ZoneState& state, std::size_t inbox_items);

}  // namespace zoned::zone
