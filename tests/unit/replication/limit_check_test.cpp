// LimitCheck: motion that breaks the promise is found, motion that keeps it is not reported.
#include "server/replication/limit_check.h"

#include <gtest/gtest.h>

namespace zoned::replication {
namespace {

constexpr float kDt = 1.0F / 30.0F;

world::EntityType type_with(float a_max, float dv_max) {
    world::EntityType type;
    type.max_acceleration_mps2 = a_max;
    type.max_velocity_jump_mps = dv_max;
    return type;
}

/// One entity that moves as semi-implicit Euler does: the velocity first, then the place.
struct Mover {
    explicit Mover(const world::EntityType& of) : type(of) {}

    bool step(const Vec3& change, const Vec3& jump = Vec3::Zero(), Tick discontinuity = 0) {
        velocity += change;
        position += velocity * kDt + jump;
        return check.exceeded(++now, discontinuity, position, velocity, spin, type, kDt);
    }

    world::EntityType type;
    LimitCheck check;
    Vec3 position = Vec3(400.0F, 1.0F, -300.0F);
    Vec3 velocity = Vec3::Zero();
    Vec3 spin = Vec3::Zero();
    Tick now = 1;
};

TEST(LimitCheck, LetsAnAccelerationAtTheLimitPassForEver) {
    Mover mover(type_with(20.0F, 0.0F));
    for (int tick = 0; tick < 300; ++tick) {
        // Back and forth, so that the speed stays in the range of the world's.
        const float sign = tick / 30 % 2 == 0 ? 1.0F : -1.0F;
        EXPECT_FALSE(mover.step(Vec3(sign * 20.0F * kDt, 0.0F, 0.0F))) << tick;
        if (tick % 30 == 29) {
            mover.velocity.setZero();
            mover.now += 5;  // a gap: motion meanwhile belongs to no one
        }
    }
}

TEST(LimitCheck, FindsASingleChangeBeyondTheJump) {
    for (const float change : {9.9F, 10.8F}) {
        Mover mover(type_with(20.0F, 10.0F));
        mover.step(Vec3::Zero());
        mover.step(Vec3::Zero());
        // 10 m/s at once and 20 m/s2 during a tick.
        EXPECT_EQ(mover.step(Vec3(0.0F, change, 0.0F)), change > 10.0F + 20.0F * kDt) << change;
        EXPECT_FALSE(mover.step(Vec3::Zero())) << "reported once";
    }
}

TEST(LimitCheck, LetsSeveralImpactsPassThatDoNotAddUp) {
    Mover mover(type_with(20.0F, 10.0F));
    mover.step(Vec3::Zero());
    for (int tick = 0; tick < 100; ++tick) {
        // Over the rims of a stair: up, level, up, level, ...
        const float sign = tick % 2 == 0 ? 1.0F : -1.0F;
        EXPECT_FALSE(mover.step(Vec3(0.0F, sign * 4.0F, 0.0F))) << tick;
    }
}

TEST(LimitCheck, FindsSeveralImpactsThatAddUpToMore) {
    Mover mover(type_with(20.0F, 10.0F));
    while (mover.now % LimitCheck::kWindowTicks != 0) {
        mover.step(Vec3::Zero());
    }
    int reported = 0;
    for (int tick = 0; tick < 6; ++tick) {
        reported += mover.step(Vec3(4.0F, 0.0F, 0.0F)) ? 1 : 0;
    }
    // After 3 of them 12 m/s, 10 + 20 * 3 / 30 are allowed; after 4 of them it is too much.
    EXPECT_EQ(reported, 1);
}

TEST(LimitCheck, FindsAnAccelerationThatGoesOnBeyondTheLimit) {
    Mover mover(type_with(5.0F, 2.0F));
    int reported = 0;
    for (int tick = 0; tick < 3 * static_cast<int>(LimitCheck::kWindowTicks); ++tick) {
        reported += mover.step(Vec3(0.0F, 0.0F, 20.0F * kDt)) ? 1 : 0;
    }
    EXPECT_GE(reported, 2);
}

TEST(LimitCheck, FindsAMoveWithoutAVelocity) {
    Mover mover(type_with(20.0F, 6.0F));
    mover.step(Vec3::Zero());
    // 6 m/s during a tick are 0.2 m, 20 m/s2 another 0.02 m.
    EXPECT_FALSE(mover.step(Vec3::Zero(), Vec3(0.0F, 0.2F, 0.0F)));
    for (int tick = 0; tick < 40; ++tick) {
        EXPECT_FALSE(mover.step(Vec3::Zero()));
    }
    EXPECT_TRUE(mover.step(Vec3::Zero(), Vec3(0.0F, 0.3F, 0.0F)));
}

TEST(LimitCheck, FindsASpinThatNoAllowedBlowCauses) {
    world::EntityType type = type_with(20.0F, 15.0F);
    type.kind = world::EntityKind::kProp;
    type.shape = world::TypeShape::kSphere;
    type.radius = 0.1F;
    Mover mover(type);
    mover.step(Vec3::Zero());
    // 15 m/s on its surface, 0.1 m from the centre: 150 rad/s.
    mover.spin = Vec3(0.0F, 150.0F, 0.0F);
    EXPECT_FALSE(mover.step(Vec3::Zero()));
    EXPECT_FALSE(mover.step(Vec3::Zero()));
    mover.spin = Vec3(0.0F, -1.0F, 0.0F);
    EXPECT_TRUE(mover.step(Vec3::Zero()));
    EXPECT_FALSE(mover.step(Vec3::Zero()));
}

TEST(LimitCheck, LetsAnnouncedJumpsPass) {
    Mover mover(type_with(20.0F, 6.0F));
    mover.step(Vec3::Zero());
    EXPECT_FALSE(mover.step(Vec3(50.0F, 0.0F, 0.0F), Vec3(100.0F, 0.0F, 0.0F), mover.now + 1));
    EXPECT_FALSE(mover.step(Vec3::Zero()));
}

}  // namespace
}  // namespace zoned::replication
