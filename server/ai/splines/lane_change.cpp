#include "server/ai/splines/lane_change.h"

#include "shared/core/assert.h"

#include <algorithm>

namespace zoned::ai::splines {

LaneChange::LaneChange(const ChangeEnd& from, const ChangeEnd& to, double length_m)
    : from_(from),
      to_(to),
      length_(length_m) {
    ZONED_ASSERT(length_m > 0.0, "a change has a length");
}

double LaneChange::distance_on_target(double walked) const {
    return to_.track->walked(to_.s, to_.offset, walked);
}

LaneChange::Moving LaneChange::at(double walked) const {
    const SplinePoint a =
        from_.track->beside(from_.track->walked(from_.s, from_.offset, walked), from_.offset);
    const SplinePoint b = to_.track->beside(distance_on_target(walked), to_.offset);
    const double t = std::clamp(walked / length_, 0.0, 1.0);
    const double share = t * t * t * (10.0 + t * (6.0 * t - 15.0));
    const double slope = 30.0 * t * t * (1.0 - t) * (1.0 - t) / length_;
    return {a.at + share * (b.at - a.at),
            a.ahead + share * (b.ahead - a.ahead) + slope * (b.at - a.at)};
}

}  // namespace zoned::ai::splines
