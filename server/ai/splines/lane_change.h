// LaneChange: from one track or lane to another, smoothly, and which track to take.
#pragma once

#include "server/ai/splines/spline.h"

#include <cstddef>
#include <cstdint>
#include <span>

namespace zoned::ai::splines {

/// The track that who has `id` takes, by chance as weights (>= 0, their sum > 0) say: the same for
/// the same seed and id.
std::size_t choose_track(std::uint64_t seed, std::uint64_t id, std::span<const double> weights);

/// Between two tracks (or lanes of one) during `length_m` > 0 of way: places are mixed by a
/// polynomial whose first and second derivatives vanish at both ends, so that neither velocity nor
/// acceleration jumps (Perlin, "Improving noise", SIGGRAPH 2002). The speed is off by at most 15/8
/// of the gap between the two over the length, and by what their directions differ.
class LaneChange {
  public:
    struct ChangeEnd {
        const Spline* track;  ///< outlives this
        double s;             ///< where the change begins, m
        double offset;        ///< m to the right
    };

    LaneChange(const ChangeEnd& from, const ChangeEnd& to, double length_m);

    [[nodiscard]] bool done(double walked) const { return walked >= length_; }

    /// After `walked` m, and in which direction (not of unit length: dp / d walked).
    struct Moving {
        Vec2d at, velocity;
    };

    [[nodiscard]] Moving at(double walked) const;

    /// Where on the other track one goes on after `walked` m.
    [[nodiscard]] double distance_on_target(double walked) const;

  private:
    ChangeEnd from_, to_;
    double length_;
};

}  // namespace zoned::ai::splines
