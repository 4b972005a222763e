// Lane numbers: how the lanes of all tracks of a world are counted.
#pragma once

#include "server/ai/splines/spline_network.h"

#include <span>

namespace zoned::ai::splines {

/// How many lanes a track has each way, and whether a racing line besides.
struct SplineLanes {
    std::uint16_t lanes = 1;
    bool races = false;

    [[nodiscard]] unsigned each_way() const { return lanes + (races ? 1U : 0U); }
};

/// The number of a lane among those of all `tracks`, which have that track and lane: track by
/// track its lanes forwards, its racing line, and the same backwards.
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
