// FollowDef: the splines that an agent follows, and how it changes lanes.
#pragma once

#include "server/ai/splines/spline_network.h"

#include <vector>

namespace zoned::ai {

/// Lanes side by side. One of them is drawn, each with the same chance.
struct LaneDraw {
    splines::LaneId first = 0;
    std::uint16_t count = 1;
    float weight = 1.0F;  ///< relative to the sum of all weights, >= 0
};

struct FollowDef {
    std::vector<LaneDraw> draws{};  ///< not empty; some have a weight
    float blend_m = 10.0F;          ///< length of a change from one lane to another, > 0
    float change_every_m = 0.0F;    ///< an agent draws a lane again after this distance; 0: never
};

}  // namespace zoned::ai
