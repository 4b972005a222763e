// Lane: a line beside a spline that followers keep to, and the longest straight segments on it.
#pragma once

#include "server/ai/splines/spline.h"

#include <cstddef>
#include <limits>
#include <vector>

namespace zoned::ai::splines {

/// The number of a lane among all lanes of a world.
using LaneId = std::uint16_t;
inline constexpr LaneId kNoLane = 0xFFFF;

/// SegmentLimits: the limits of a straight segment that begins on a lane.
struct SegmentLimits {
    double off_m = 0.1;  ///< farthest from the lane between its ends, m
    double turn = 1.0;   ///< the most by which the lane may turn, rad
    double most_m = 256.0;
};

/// A curve through places beside the middle of a spline. Its own length is the distance that a
/// follower walks.
class Lane {
  public:
    /// `offset` m to the right of the middle (at most half its width). `error_m`: how far followers
    /// may be off; at most a tenth of it goes into the curve itself. Errors are those of
    /// Spline::make.
    static core::Result<Lane> make(const Spline& middle, double offset, double error_m);

    [[nodiscard]] const Spline& curve() const { return curve_; }

    [[nodiscard]] double length() const { return curve_.length(); }

    [[nodiscard]] bool closed() const { return curve_.closed(); }

    [[nodiscard]] SplinePoint at(double s) const { return curve_.at(s); }

    [[nodiscard]] double error_m() const { return error_m_; }

    /// The largest curvature of the lane, 1/m.
    [[nodiscard]] double most_curved() const;

    /// The length of a straight line from `s` (on the lane) that the lane keeps within `limits`, m.
    /// It is at least kLeast_m, and at most leads to the end of an open lane. Take an arc of length
    /// L that turns by T with curvatures up to k. It is within L min(T / 4, k L / 8) of its chord,
    /// and at most L T^2 / 8 longer. Source: Schur's comparison theorem; Guggenheimer,
    /// "Differential Geometry", 1963, section 2-6.
    [[nodiscard]] double segment_m(double s, const SegmentLimits& limits) const;

    static constexpr double kLeast_m = 0.5;

    struct NearestOnLane {
        double s = 0.0;
        double distance_m = std::numeric_limits<double>::infinity();
    };

    /// The nearest place of the whole lane, or of the part within `reach_m` along it of `about`.
    /// The search tries stations first, then halves the steps beside the best.
    [[nodiscard]] NearestOnLane nearest(const Vec2d& at) const;
    [[nodiscard]] NearestOnLane nearest(const Vec2d& at, double about, double reach_m) const;

    /// The nearest place by the chords between stations, for the cost of a look at each station. No
    /// station is farther from the next than a quarter of the radius of the sharpest bend, and no
    /// arc higher than 0.4 error_m. So the distance is off by 0.4 error_m at most, and the place of
    /// a point b beside the lane by b / 8.
    [[nodiscard]] NearestOnLane nearest_by_chords(const Vec2d& at) const;

    /// `s` brought onto the lane: into [0, length) on a closed lane, else between its ends.
    [[nodiscard]] double on_lane(double s) const;

    [[nodiscard]] std::size_t bytes() const;

  private:
    explicit Lane(Spline curve) : curve_(std::move(curve)) {}

    void survey(double spacing_m);
    [[nodiscard]] std::size_t nearest_station(const Vec2d& at) const;
    [[nodiscard]] NearestOnLane refine(const Vec2d& at, double s, double step) const;

    Spline curve_;
    double error_m_ = 0.25;
    double station_m_ = 1.0;
    std::vector<Vec2d> place_;   // by station, every station_m_ along the lane
    std::vector<float> curved_;  // the largest curvature from a station to the next, 1/m
    std::vector<float> turned_;  // the turn of the lane from a station to the next, rad
};

}  // namespace zoned::ai::splines
