// SplineFollowing: moves agents along splines by a timetable that is exact to the centimetre.
#pragma once

#include "server/ai/steering/desired_velocity.h"

namespace zoned::ai {

/// The contents of Agent::corner while it follows a spline.
inline constexpr std::uint8_t kJoins = 0;  ///< walks to the spline: `target`
inline constexpr std::uint8_t kOnTrack = 1;
inline constexpr std::uint8_t kTrackEnds = 2;  ///< stands where its spline ended: `target`

/// Draws a lane from the agent's own stream of random numbers.
void begin_spline(Agent& agent, const BrainState& state, const Surroundings& around);

/// Called once the segment is over, or has to be made anew: sets the next one along the spline. A
/// segment is as long as three limits allow. Its line lies within 0.5 error_m of the lane.
/// The body's acceleration costs at most 0.25 error_m in its turn. One tick's path beyond its end
/// leads off by less than 0.15 error_m. The rest of the error is for the curve of the lane.
///
/// The speed is chosen so that the end is reached on the timetable's time; errors do not add up. A
/// follower stays within error_m of the ideal place at even speed along the lane, as long as nobody
/// blocks it. A follower that was held up or pushed by more than 1.5 m goes on from where it is, by
/// a new timetable.
///
/// False: it is not on the spline, and walks to Agent::target as to any goal.
bool follow_spline(Agent& agent, const BrainState& state, const Surroundings& around);

/// For followers without segments (in a blend): the velocity to a place ahead on the spline.
DesiredVelocity track_velocity(Agent& agent, const BrainState& state, const Surroundings& around);

/// How far a player at `player` (x, z, m) is ahead of where a follower is due on its lane, m; below
/// 0: behind. On a closed spline the shorter way counts. NaN: the player does not drive there but
/// is farther than 8 m from the lane, or the agent is not on its spline.
[[nodiscard]] float ahead_on_track(const Agent& agent,
                                   const Vec2& player,
                                   const Surroundings& around);

/// SplinePlace: the position of an agent on its spline, for display to people. It is the place that
/// the timetable has for the end of the agent's segment.
struct SplinePlace {
    splines::LaneId lane = splines::kNoLane;
    double s = 0.0;       ///< m along the spline
    double length = 0.0;  ///< of the spline, m
};

[[nodiscard]] SplinePlace spline_place(const Agent& agent,
                                       const PointsOfInterest& points_of_interest);

}  // namespace zoned::ai
