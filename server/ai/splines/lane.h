// Lane: one line that followers of a track keep to, by its own length, and how far they may walk
// straight on it.
#pragma once

#include "server/ai/splines/spline.h"

#include <cstddef>
#include <limits>
#include <vector>

namespace zoned::ai::splines {

/// Names a lane among all lanes of a world.
using LaneId = std::uint16_t;
inline constexpr LaneId kNoLane = 0xFFFF;

/// What a straight segment that begins on a lane may be.
struct SegmentLimits {
    double off_m = 0.1;  ///< farthest from the lane between its ends, m
    double turn = 1.0;   ///< rad that the lane may turn by
    double most_m = 256.0;
};

/// A curve of its own through places beside the middle of a track, so that its length is what a
/// follower walks.
class Lane {
  public:
    /// `offset` m to the right of the middle (half its width at most). `error_m`: what followers
    /// may be off; a tenth of it at most goes into the curve itself. Errors are those of
    /// Spline::make.
    static core::Result<Lane> make(const Spline& middle, double offset, double error_m);

    [[nodiscard]] const Spline& curve() const { return curve_; }

    [[nodiscard]] double length() const { return curve_.length(); }

    [[nodiscard]] bool closed() const { return curve_.closed(); }

    [[nodiscard]] SplinePoint at(double s) const { return curve_.at(s); }

    [[nodiscard]] double error_m() const { return error_m_; }

    /// The largest of its curvatures, 1/m.
    [[nodiscard]] double most_curved() const;

    /// How far on from `s` (on the lane) a straight line leads that the lane keeps within
    /// `limits`, m: at least kLeast_m, at most to the end of an open lane. An arc of length L that
    /// turns by T with curvatures up to k is within L min(T / 4, k L / 8) of its chord, and L T^2 /
    /// 8 longer at most (Schur's comparison theorem; Guggenheimer, "Differential Geometry", 1963,
    /// section 2-6).
    [[nodiscard]] double segment_m(double s, const SegmentLimits& limits) const;

    static constexpr double kLeast_m = 0.5;

    struct NearestOnLane {
        double s = 0.0;
        double distance_m = std::numeric_limits<double>::infinity();
    };

    /// The nearest place of the lane: of all of it, or of what is within `reach_m` along it of
    /// `about`. (Stations first, then halving of the steps beside the best.)
    [[nodiscard]] NearestOnLane nearest(const Vec2d& at) const;
    [[nodiscard]] NearestOnLane nearest(const Vec2d& at, double about, double reach_m) const;

    /// On a closed lane within [0, length), else within its ends.
    [[nodiscard]] double on_lane(double s) const;

    [[nodiscard]] std::size_t bytes() const;

  private:
    explicit Lane(Spline curve) : curve_(std::move(curve)) {}

    void survey(double spacing_m);
    [[nodiscard]] NearestOnLane refine(const Vec2d& at, double s, double step) const;

    Spline curve_;
    double error_m_ = 0.25;
    double station_m_ = 1.0;
    std::vector<Vec2d> place_;   // by station, every station_m_ along the lane
    std::vector<float> curved_;  // the largest curvature from a station to the next, 1/m
    std::vector<float> turned_;  // what the lane turns by from a station to the next, rad
};

}  // namespace zoned::ai::splines
