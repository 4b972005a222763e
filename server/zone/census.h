// Census: the contents of a zone as the basis of its plan, from kept counts and a look at active
// entities.
#pragma once

#include "server/zone/zone_state.h"

namespace zoned::zone {

Census take_census(const ZoneState& state, std::size_t inbox_items);

}  // namespace zoned::zone
