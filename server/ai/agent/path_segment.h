// PathSegment: a straight walk by a timetable, or standing still. It gives the walker's position at
// any tick.
#pragma once

#include "shared/core/ids.h"
#include "shared/math/types.h"

namespace zoned::ai {

/// Later than any tick.
inline constexpr Tick kNever = Tick{1} << 62U;

/// The motion that motion::apply_input makes of a held command with nothing in the way.
/// Acceleration is constant from the first velocity to the commanded one, which is then kept.
///
/// Let T be the time of the acceleration, v the commanded velocity, and d the change to it. The
/// position at time t after the beginning is from + v t + (d / 2T) max(0, T - t)^2.
struct PathSegment {
    Vec2 from = Vec2::Zero();  ///< x, z: start of the walk at full speed, extended backwards, m
    Vec2 direction = Vec2::Zero();  ///< unit length
    float speed = 0.0F;             ///< m/s; 0: it stands, once it has come to a halt
    float length = 0.0F;            ///< to where the goal counts as reached, m; 0: no goal
    Vec2 bend = Vec2::Zero();       ///< half the acceleration at the beginning, m/s2
    float bend_s = 0.0F;            ///< duration of that acceleration
    Tick since = 0;                 ///< it begins at the end of this tick
    Vec2 goal = Vec2::Zero();       ///< end of the walk, which may lie beyond this segment
};

/// The end of a segment that has a goal.
inline Vec2 end_of(const PathSegment& segment) {
    return segment.from + segment.direction * segment.length;
}

/// Time from the beginning of a segment to the end of `tick`, which is not before it, s.
inline float time_on(const PathSegment& segment, Tick tick, float dt) {
    return static_cast<float>(tick - segment.since) * dt;
}

/// Position x, z at the end of `tick`, m; `dt` in s. A walk goes on beyond its end.
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

/// A segment from `here` at the end of `tick`, without a goal. It changes from `velocity` to
/// `speed` along `direction` (unit length) by `acceleration` (m/s2; 0: at once).
PathSegment segment_from(const Vec2& here,
                         const Vec2& velocity,
                         const Vec2& direction,
                         float speed,
                         float acceleration,
                         Tick tick);

/// A tick > `now` before which a walker along the segment does not cross the circle around `centre`
/// (x, z, m). It does not enter from outside, or does not leave from inside. The walker is on the
/// segment at the end of `now` - 1. Rounding of floats is allowed for. kNever: it will not cross.
Tick stays_until(const PathSegment& segment,
                 const Vec2& centre,
                 float radius_m,
                 Tick now,
                 float dt);

/// The tick at whose beginning the goal of a segment that has one is reached.
Tick arrival_of(const PathSegment& segment, float dt);

}  // namespace zoned::ai
