// Zone portal exchange: the data that zones share to plan paths through several of them.
#pragma once

#include <span>

namespace zoned::zone {

struct ZoneState;

/// Makes the portals of the world from the maps of all its zones, in the order of their ids, for
/// each size of character. Gives them to each zone. Once, before the first tick; nothing where no
/// paths are planned, or there is but one zone.
void join_paths(std::span<ZoneState* const> zones);

}  // namespace zoned::zone
