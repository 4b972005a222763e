// RacingLine: the least curved line within the width of a track.
#pragma once

#include "server/ai/splines/spline.h"

#include <cstddef>
#include <vector>

namespace zoned::ai::splines {

/// PointsOfInterest across a closed track, evenly spaced along it.
struct RacingLine {
    std::vector<double> offset;  ///< m to the right of the middle

    /// The sum of squared second differences, which was made least.
    double bend = 0.0;
};

/// Offsets at `samples` (16 to 65,536, a power of two) places, none more than half the width less
/// `margin_m` (0 to half the width), for which the sum of the squared second differences of the
/// places is least: for even spacing its curvature squared. (Braghin, Cheli, Melzi and Sabbioni,
/// "Race driver model", Computers and Structures 86, 2008, section 3, by coordinate descent from
/// coarse to fine, `sweeps` of each; counted, not timed.) The track is closed.
RacingLine racing_line(const Spline& track, std::size_t samples, double margin_m, int sweeps = 400);

/// A track of the same width / 4 along it.
core::Result<Spline> track_along(const Spline& track, const RacingLine& line);

}  // namespace zoned::ai::splines
