// SplineFollowing: agents that go along tracks, by a timetable that is kept to the centimetre.
#pragma once

#include "server/ai/steering/desired_velocity.h"

namespace zoned::ai {

/// What an agent keeps in `corner` while it follows a track.
inline constexpr std::uint8_t kJoins = 0;  ///< on its way to the track: `target`
inline constexpr std::uint8_t kOnTrack = 1;
inline constexpr std::uint8_t kTrackEnds = 2;  ///< it stands where its track ended: `target`

/// A lane is drawn, by the agent's own stream of random numbers.
void begin_spline(Agent& agent, const BrainState& state, const Surroundings& around);

/// Once the segment is over, or is to be made anew: sets the next one along the track. A segment is
/// as long as its line is within 0.5 error_m of the lane, its turn within what a body that
/// accelerates as this one does takes 0.25 error_m for, and a tick's path beyond its end leads off
/// by less than 0.15 error_m; what is left is for the curve of the lane. It is walked at the speed
/// by which its end is reached when the timetable says, so that nothing adds up: a follower is
/// within error_m of the place where one would be who walked along the lane at even speed, as long
/// as nobody is in its path. Who was held up or pushed by more than 1.5 m goes on from where it is,
/// by another timetable.
///
/// False: it is not on the track, and walks to Agent::target as to any goal.
bool follow_spline(Agent& agent, const BrainState& state, const Surroundings& around);

/// For followers that go by no segments (in a blend): to a place ahead on the track.
DesiredVelocity track_velocity(Agent& agent, const BrainState& state, const Surroundings& around);

/// Where on its track an agent is that goes along it, for people: the place that the timetable has
/// for the end of its segment.
struct SplinePlace {
    splines::LaneId lane = splines::kNoLane;
    double s = 0.0;       ///< m along it
    double length = 0.0;  ///< of it, m
};

[[nodiscard]] SplinePlace spline_place(const Agent& agent,
                                       const PointsOfInterest& points_of_interest);

}  // namespace zoned::ai
