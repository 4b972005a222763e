// Cosmetic particle systems as the server tells them at login: checked, and ready to be replayed.
#pragma once

#include "client-sim/view/world_info.h"

#include <string>
#include <vector>

namespace zoned::view {

/// Why a client could not replay the description's cosmetic systems in good time; empty: it can.
std::string wrong_with_cosmetics(const proto::WorldDescription& description);

/// Needs what wrong_with_cosmetics() has checked.
std::vector<CosmeticInfo> read_cosmetics(const proto::WorldDescription& description);

}  // namespace zoned::view
