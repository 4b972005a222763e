// RacingLine: the least curved line within the width of a closed spline.
#pragma once

#include "server/ai/splines/spline.h"

#include <cstddef>
#include <vector>

namespace zoned::ai::splines {

/// Places across a closed spline, evenly spaced along it.
struct RacingLine {
    std::vector<double> offset;  ///< m to the right of the middle

    /// The minimised sum of squared second differences.
    double bend = 0.0;
};

/// Offsets at `samples` places (16 to 65,536, a power of two), at most half the width less
/// `margin_m` (0 to half the width). They minimise the sum of the squared second differences of the
/// places; for even spacing that is the squared curvature. The method is coordinate descent from
/// coarse to fine with `sweeps` on each level; it is bounded by count, not by time. Source:
/// Braghin, Cheli, Melzi and Sabbioni, "Race driver model", Computers and Structures 86, 2008,
/// section 3. The spline is closed.
RacingLine racing_line(const Spline& track, std::size_t samples, double margin_m, int sweeps = 400);

/// A spline along the racing line with a quarter of the width.
core::Result<Spline> track_along(const Spline& track, const RacingLine& line);

}  // namespace zoned::ai::splines
