// Legs: where their walkers are, against movement's own function.
#include "server/ai/leg.h"

#include "shared/motion/apply_input.h"

#include <gtest/gtest.h>

namespace zoned::ai {
namespace {

constexpr float kLegDt = 1.0F / 20.0F;

/// On level ground a command that is held leads along the leg: apply_input accelerates exactly, so
/// that what is left is rounding, some ulp of 100 m per tick.
TEST(Leg, IsTheWayOfACharacterWhoseCommandIsHeld) {
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
    const Leg leg = leg_from(Vec2(body.position.x(), body.position.z()),
                             Vec2(body.velocity.x(), body.velocity.z()),
                             move / move.norm(),
                             move.norm() * limits.speed,
                             limits.acceleration,
                             0);
    for (Tick tick = 1; tick <= 200; ++tick) {
        body = motion::apply_input(body, command, limits, ground, kLegDt);
        const Vec2 at = position_at(leg, tick, kLegDt);
        const Vec2 velocity = velocity_at(leg, tick, kLegDt);
        EXPECT_NEAR(at.x(), body.position.x(), 1e-3F) << tick;
        EXPECT_NEAR(at.y(), body.position.z(), 1e-3F) << tick;
        EXPECT_NEAR(velocity.x(), body.velocity.x(), 1e-4F) << tick;
        EXPECT_NEAR(velocity.y(), body.velocity.z(), 1e-4F) << tick;
    }
}

TEST(Leg, EndsWhereABodyComesToAHalt) {
    // v^2 / 2a = 16 / 8 = 2 m, in 1 s.
    const Leg leg = leg_from(Vec2(1.0F, 0.0F), Vec2(4.0F, 0.0F), Vec2::Zero(), 0.0F, 4.0F, 10);
    EXPECT_FLOAT_EQ(position_at(leg, 10, kLegDt).x(), 1.0F);
    EXPECT_FLOAT_EQ(position_at(leg, 20, kLegDt).x(), 1.0F + 4.0F * 0.5F - 0.5F * 4.0F * 0.25F);
    EXPECT_FLOAT_EQ(position_at(leg, 30, kLegDt).x(), 3.0F);
    EXPECT_FLOAT_EQ(position_at(leg, 300, kLegDt).x(), 3.0F);
    EXPECT_FLOAT_EQ(velocity_at(leg, 10, kLegDt).x(), 4.0F);
    EXPECT_FLOAT_EQ(velocity_at(leg, 20, kLegDt).x(), 2.0F);
    EXPECT_FLOAT_EQ(velocity_at(leg, 30, kLegDt).x(), 0.0F);
}

TEST(Leg, ArrivesAtTheFirstTickThatBeginsBeyondItsLength) {
    Leg leg = leg_from(Vec2::Zero(), Vec2::Zero(), Vec2(0.0F, 1.0F), 2.0F, 0.0F, 5);
    leg.length = 1.05F;
    const Tick arrival = arrival_of(leg, kLegDt);
    // A tick begins where the one before it has ended.
    EXPECT_GE(position_at(leg, arrival - 1, kLegDt).y(), leg.length);
    EXPECT_LT(position_at(leg, arrival - 2, kLegDt).y(), leg.length);
}

}  // namespace
}  // namespace zoned::ai
