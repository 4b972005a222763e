// cosmetics: checks the cosmetic particle systems of the login message and prepares them for
// replay.
#pragma once

#include "client-sim/view/world_info.h"

#include <string>
#include <vector>

namespace zoned::view {

/// Reason why a client could not replay the description's cosmetic systems in time; empty: it can.
std::string wrong_with_cosmetics(const wire::WorldDescriptionMessage& description);

/// Needs a description that passed wrong_with_cosmetics().
std::vector<CosmeticInfo> read_cosmetics(const wire::WorldDescriptionMessage& description);

}  // namespace zoned::view
