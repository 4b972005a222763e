// PathSegment: a straight walk by a timetable, or standing; where its walker is at any tick follows
// from it.
#pragma once

#include "shared/core/ids.h"
#include "shared/math/types.h"

namespace zoned::ai {

/// Later than any tick.
inline constexpr Tick kNever = Tick{1} << 62U;

/// What motion::apply_input makes of a command that is held where nothing is in the way: constant
/// acceleration from the velocity before to that commanded, which it keeps. With T the time that
/// takes, v the velocity commanded, d the change to it, the place t after the beginning is
/// from + v t + (d / 2T) max(0, T - t)^2.
struct PathSegment {
    Vec2 from = Vec2::Zero();       ///< x, z: where the walk at full speed leads back to, m
    Vec2 direction = Vec2::Zero();  ///< unit length
    float speed = 0.0F;             ///< m/s; 0: it stands, once it has come to a halt
    float length = 0.0F;            ///< to where the goal counts as reached, m; 0: it has none
    Vec2 bend = Vec2::Zero();       ///< half the acceleration at the beginning, m/s2
    float bend_s = 0.0F;            ///< and how long that takes
    Tick since = 0;                 ///< it begins at the end of this tick
    Vec2 goal = Vec2::Zero();       ///< where the walk leads, on from the end of this segment maybe
};

/// Where a segment that has one ends.
inline Vec2 end_of(const PathSegment& segment) {
    return segment.from + segment.direction * segment.length;
}

/// s from the beginning of a segment to the end of `tick`, not before it.
inline float time_on(const PathSegment& segment, Tick tick, float dt) {
    return static_cast<float>(tick - segment.since) * dt;
}

/// Position x, z of the end of `tick`, m; `dt` in s. Whoever walks walks on.
inline Vec2 position_at(const PathSegment& segment, Tick tick, float dt) {
    const float t = time_on(segment, tick, dt);
    const Vec2 steady = segment.from + segment.direction * (segment.speed * t);
    const float left = segment.bend_s - t;
    return left > 0.0F ? Vec2(steady + segment.bend * (left * left)) : steady;
}

/// Velocity x, z at the end of `tick`, m/s.
inline Vec2 velocity_at(const PathSegment& segment, Tick tick, float dt) {
    const Vec2 steady = segment.direction * segment.speed;
    const float left = segment.bend_s - time_on(segment, tick, dt);
    return left > 0.0F ? Vec2(steady - segment.bend * (2.0F * left)) : steady;
}

/// A segment from `here` at the end of `tick` that goes over from `velocity` to that along
/// `direction` (unit length) at `speed`, by `acceleration` (m/s2; 0: at once). Without a goal.
PathSegment segment_from(const Vec2& here,
                         const Vec2& velocity,
                         const Vec2& direction,
                         float speed,
                         float acceleration,
                         Tick tick);

/// A tick > `now` before which who goes on along the segment, and is there at the end of `now` - 1,
/// does not come into the circle around `centre` (x, z, m), or does not leave it where it is
/// inside; what floats make of either is allowed for. kNever: it will not.
Tick stays_until(const PathSegment& segment,
                 const Vec2& centre,
                 float radius_m,
                 Tick now,
                 float dt);

/// The tick at whose beginning the goal of a segment that has one is reached.
Tick arrival_of(const PathSegment& segment, float dt);

}  // namespace zoned::ai
