// Lane numbers: lane_number() numbers the lanes of all splines of a world.
#pragma once

#include "server/ai/splines/spline_network.h"

#include <span>

namespace zoned::ai::splines {

/// SplineLanes: the number of lanes of a spline in each direction, and whether it also has a racing
/// line.
struct SplineLanes {
    std::uint16_t lanes = 1;
    bool races = false;

    [[nodiscard]] unsigned each_way() const { return lanes + (races ? 1U : 0U); }
};

/// The number of a lane among the lanes of all `tracks`, which must contain that spline and lane.
/// Splines come one after the other, each with its lanes forwards, its racing line, and the same
/// backwards.
inline LaneId lane_number(std::span<const SplineLanes> tracks, const LaneChoice& choice) {
    unsigned number = 0;
    for (std::size_t t = 0; t < choice.track; ++t) {
        number += 2U * tracks[t].each_way();
    }
    const SplineLanes& track = tracks[choice.track];
    number += choice.backwards ? track.each_way() : 0U;
    return static_cast<LaneId>(number + (choice.racing_line ? track.lanes : choice.lane));
}

}  // namespace zoned::ai::splines
