#include "server/ai/agent/path_segment.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace zoned::ai {

namespace {

constexpr double kNoTime = std::numeric_limits<double>::infinity();

/// The relative rounding error of places of a walk and their distances. A product, two sums and a
/// norm round six times, each by half of 2^-23.
constexpr double kRounded = 0x1.0p-20;

/// A walk at constant velocity, seen from the middle of a circle; m, s.
struct Passage {
    Vec2d from;  ///< at time 0
    Vec2d velocity;
    double radius;

    /// The first time from `now` on at which the walker is within `margin` of the circle; kNoTime:
    /// never.
    [[nodiscard]] double meets(double now, double margin) const {
        const Vec2d at = from + velocity * now;
        const double distance = at.norm();
        if (!(std::abs(distance - radius) > margin)) {
            return now;
        }
        const bool inside = distance < radius;
        const double edge = inside ? radius - margin : radius + margin;
        // |at + velocity t| = edge: a t^2 + 2 b t + c = 0.
        const double a = velocity.squaredNorm();
        const double b = at.dot(velocity);
        const double c = at.squaredNorm() - edge * edge;
        const double discriminant = b * b - a * c;
        if (!(a > 0.0) || (!inside && (b >= 0.0 || discriminant < 0.0))) {
            return kNoTime;
        }
        const double root = std::sqrt(std::max(0.0, discriminant));
        return now + std::max(0.0, (inside ? root - b : -root - b) / a);
    }
};

}  // namespace

Tick stays_until(const PathSegment& segment,
                 const Vec2& centre,
                 float radius_m,
                 Tick now,
                 float dt) {
    const Passage passage{(segment.from - centre).cast<double>(),
                          segment.direction.cast<double>() * static_cast<double>(segment.speed),
                          static_cast<double>(radius_m)};
    const double rounded =
        kRounded * static_cast<double>(segment.from.norm() + centre.norm() + std::abs(radius_m));
    const double step = static_cast<double>(dt);
    const double since = static_cast<double>(now - 1 - segment.since) * step;
    // During the turn it is at most this far from the walk at full speed.
    const double turns = std::max(0.0, static_cast<double>(segment.bend_s) - since);
    const double aside = static_cast<double>(segment.bend.norm()) * turns * turns;
    double meets = passage.meets(since, rounded + aside);
    if (aside > 0.0 && !(meets < static_cast<double>(segment.bend_s))) {
        meets = passage.meets(since, rounded);
    }
    const double ticks = std::floor(meets / step);
    return ticks < 1e9 ? std::max(now + 1, segment.since + 1 + static_cast<Tick>(ticks)) : kNever;
}

PathSegment segment_from(const Vec2& here,
                         const Vec2& velocity,
                         const Vec2& direction,
                         float speed,
                         float acceleration,
                         Tick tick) {
    PathSegment segment;
    segment.direction = direction;
    segment.speed = speed;
    segment.since = tick;
    segment.from = here;
    const Vec2 change = direction * speed - velocity;
    const float size = change.norm();
    if (acceleration > 0.0F && size > 0.0F) {
        segment.bend_s = size / acceleration;
        segment.bend = change * (0.5F * acceleration / size);
        segment.from -= segment.bend * (segment.bend_s * segment.bend_s);
    }
    return segment;
}

Tick arrival_of(const PathSegment& segment, float dt) {
    const float ticks = std::floor(segment.length / (segment.speed * dt));
    return segment.since + 2 + static_cast<Tick>(std::clamp(ticks, 0.0F, 1e9F));
}

}  // namespace zoned::ai
