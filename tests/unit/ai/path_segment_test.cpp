// build: computes
// Path segments: the places of their walkers, against movement's own function.
#include "server/ai/agent/path_segment.h"

#include "shared/core/rng.h"
#include "shared/motion/apply_input.h"

#include <gtest/gtest.h>

namespace zoned::ai {
namespace {

constexpr float kSegmentDt = 1.0F / 20.0F;

/// On level ground a held command leads along the segment. apply_input accelerates exactly, so only
/// rounding remains, some ulp of 100 m per tick.
TEST(PathSegment, IsTheWayOfACharacterWhoseCommandIsHeld) {
    const motion::StaticGeometry ground({}, 0.0F);
    motion::CharacterLimits limits;
    limits.speed = 6.0F;
    limits.acceleration = 9.0F;
    motion::CharacterState body;
    body.position = Vec3(40.0F, limits.radius + limits.half_segment, -30.0F);
    body.velocity = Vec3(-5.0F, 0.0F, 2.0F);
    body.grounded = true;
    motion::InputCommand command;
    command.move_x = 90;
    command.move_z = 60;
    const Vec2 move = Vec2(90.0F, 60.0F) / 127.0F;
    const PathSegment segment = segment_from(Vec2(body.position.x(), body.position.z()),
                                             Vec2(body.velocity.x(), body.velocity.z()),
                                             move / move.norm(),
                                             move.norm() * limits.speed,
                                             limits.acceleration,
                                             0);
    for (Tick tick = 1; tick <= 200; ++tick) {
        body = motion::apply_input(body, command, limits, ground, kSegmentDt);
        const Vec2 at = position_at(segment, tick, kSegmentDt);
        const Vec2 velocity = velocity_at(segment, tick, kSegmentDt);
        EXPECT_NEAR(at.x(), body.position.x(), 1e-3F) << tick;
        EXPECT_NEAR(at.y(), body.position.z(), 1e-3F) << tick;
        EXPECT_NEAR(velocity.x(), body.velocity.x(), 1e-4F) << tick;
        EXPECT_NEAR(velocity.y(), body.velocity.z(), 1e-4F) << tick;
    }
}

TEST(PathSegment, EndsWhereABodyComesToAHalt) {
    // v^2 / 2a = 16 / 8 = 2 m, in 1 s.
    const PathSegment segment =
        segment_from(Vec2(1.0F, 0.0F), Vec2(4.0F, 0.0F), Vec2::Zero(), 0.0F, 4.0F, 10);
    EXPECT_FLOAT_EQ(position_at(segment, 10, kSegmentDt).x(), 1.0F);
    EXPECT_FLOAT_EQ(position_at(segment, 20, kSegmentDt).x(),
                    1.0F + 4.0F * 0.5F - 0.5F * 4.0F * 0.25F);
    EXPECT_FLOAT_EQ(position_at(segment, 30, kSegmentDt).x(), 3.0F);
    EXPECT_FLOAT_EQ(position_at(segment, 300, kSegmentDt).x(), 3.0F);
    EXPECT_FLOAT_EQ(velocity_at(segment, 10, kSegmentDt).x(), 4.0F);
    EXPECT_FLOAT_EQ(velocity_at(segment, 20, kSegmentDt).x(), 2.0F);
    EXPECT_FLOAT_EQ(velocity_at(segment, 30, kSegmentDt).x(), 0.0F);
}

TEST(PathSegment, ArrivesAtTheFirstTickThatBeginsBeyondItsLength) {
    PathSegment segment = segment_from(Vec2::Zero(), Vec2::Zero(), Vec2(0.0F, 1.0F), 2.0F, 0.0F, 5);
    segment.length = 1.05F;
    const Tick arrival = arrival_of(segment, kSegmentDt);
    // A tick begins where the one before it has ended.
    EXPECT_GE(position_at(segment, arrival - 1, kSegmentDt).y(), segment.length);
    EXPECT_LT(position_at(segment, arrival - 2, kSegmentDt).y(), segment.length);
}

/// The first tick after `now` at whose start the walker is on the other side of the circle, or
/// `last`.
Tick crosses_at(const PathSegment& segment,
                const Vec2& centre,
                float radius_m,
                Tick now,
                Tick last) {
    const auto inside = [&](Tick tick) {
        return (position_at(segment, tick - 1, kSegmentDt) - centre).norm() < radius_m;
    };
    const bool before = inside(now);
    Tick tick = now + 1;
    while (tick < last && inside(tick) == before) {
        ++tick;
    }
    return tick;
}

/// Never late, against every tick of walks in all directions, near and far, that turn and brake.
/// Not early either: by two ticks where the walk is straight and meets the circle steeply. One is
/// for the cut-off, one for rounding.
TEST(PathSegment, StaysUntilItCrossesACircle) {
    core::Rng rng(11);
    const auto point = [&rng](float size) {
        return Vec2(rng.range(-size, size), rng.range(-size, size));
    };
    constexpr Tick kLast = 2'000;
    int crossings = 0;
    int steep = 0;
    for (int n = 0; n < 3'000; ++n) {
        const float far = n % 2 == 0 ? 5.0F : 5'000.0F;
        const Vec2 here = point(far);
        const Vec2 centre = here + point(n % 3 == 0 ? 3.0F : 60.0F);
        const float radius_m = rng.range(0.5F, 20.0F);
        const Vec2 velocity = n % 4 == 0 ? point(6.0F) : Vec2(Vec2::Zero());
        const float speed = n % 16 == 0 ? 0.0F : rng.range(0.2F, 6.0F);
        const Vec2 heading = point(1.0F).normalized();
        const PathSegment segment =
            segment_from(here, velocity, heading, speed, n % 4 == 0 ? 9.0F : 0.0F, 40);
        for (const Tick now : {Tick{41}, Tick{47}, Tick{140}}) {
            const Tick until = stays_until(segment, centre, radius_m, now, kSegmentDt);
            const Tick crosses = crosses_at(segment, centre, radius_m, now, kLast);
            ASSERT_LE(until, crosses == kLast ? kNever : crosses) << n << " from " << now;
            ASSERT_GT(until, now) << n;
            crossings += crosses < kLast ? 1 : 0;
            // So much of the speed leads across the circle that rounding at 5 km is below a step.
            const Vec2 there = position_at(segment, crosses - 1, kSegmentDt) - centre;
            const bool is_steep = std::abs(heading.dot(there.normalized())) * speed > 1.0F;
            if (crosses < kLast && n % 4 != 0 && is_steep) {
                ++steep;
                ASSERT_GE(until, std::min(crosses, std::max(now + 1, crosses - 2))) << n;
            }
        }
    }
    EXPECT_GT(crossings, 1'000);
    EXPECT_GT(steep, 500);
}

TEST(PathSegment, StaysForEverWhereItLeadsElsewhere) {
    const PathSegment segment =
        segment_from(Vec2(10.0F, 0.0F), Vec2::Zero(), Vec2(1.0F, 0.0F), 2.0F, 0.0F, 0);
    EXPECT_EQ(stays_until(segment, Vec2::Zero(), 4.0F, 1, kSegmentDt), kNever) << "away";
    EXPECT_EQ(stays_until(segment, Vec2(20.0F, 9.0F), 4.0F, 1, kSegmentDt), kNever) << "past it";
    PathSegment stands = segment;
    stands.speed = 0.0F;
    EXPECT_EQ(stays_until(stands, Vec2(20.0F, 0.0F), 4.0F, 1, kSegmentDt), kNever);
    EXPECT_EQ(stays_until(stands, Vec2(20.0F, 0.0F), 10.0F, 1, kSegmentDt), 2) << "nobody can tell";
}

}  // namespace
}  // namespace zoned::ai
