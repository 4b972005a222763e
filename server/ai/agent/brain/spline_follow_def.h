// FollowDef: which tracks an agent follows, and how it goes from one to another.
#pragma once

#include "server/ai/splines/spline_network.h"

#include <vector>

namespace zoned::ai {

/// Lanes side by side, one of which is drawn, each as likely as the others.
struct LaneDraw {
    splines::LaneId first = 0;
    std::uint16_t count = 1;
    float weight = 1.0F;  ///< of all of them together, >= 0
};

struct FollowDef {
    std::vector<LaneDraw> draws{};  ///< not empty; some have a weight
    float blend_m = 10.0F;          ///< way over which one changes from a lane to another, > 0
    float change_every_m = 0.0F;    ///< after so much way one draws anew; 0: never
};

}  // namespace zoned::ai
