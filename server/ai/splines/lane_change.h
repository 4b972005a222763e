// LaneChange: a smooth change between splines or lanes.
#pragma once

#include "server/ai/splines/spline.h"

namespace zoned::ai::splines {

/// A change between two splines (or lanes of one) over a distance of `length_m` > 0. Places are
/// mixed by a polynomial whose first and second derivatives vanish at both ends. So neither
/// velocity nor acceleration jumps (Perlin, "Improving noise", SIGGRAPH 2002). The speed is off by
/// at most 15/8 of the gap between the two over the length, plus the difference of their
/// directions.
class LaneChange {
  public:
    struct ChangeEnd {
        const Spline* track;  ///< must outlive this
        double s;             ///< start of the change, m
        double offset;        ///< m to the right
    };

    LaneChange(const ChangeEnd& from, const ChangeEnd& to, double length_m);

    [[nodiscard]] bool done(double walked) const { return walked >= length_; }

    /// The position after `walked` m, and the direction there (not of unit length: dp / d walked).
    struct Moving {
        Vec2d at, velocity;
    };

    [[nodiscard]] Moving at(double walked) const;

    /// The distance on the other spline at which the agent goes on after `walked` m.
    [[nodiscard]] double distance_on_target(double walked) const;

  private:
    ChangeEnd from_, to_;
    double length_;
};

}  // namespace zoned::ai::splines
