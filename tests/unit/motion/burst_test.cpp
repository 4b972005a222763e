// Bursts: the emitter that follows from a kind and an event, and kinds that are refused.
#include "shared/motion/burst.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace zoned::motion {
namespace {

BurstKind shards() {
    return {0.8F, 0.25F, 0.1F, 0.5F, 2.0F};
}

TEST(Burst, LetsAllParticlesOutInOneStepWithinConeSpreadAndSpeeds) {
    const Burst burst{77, 40, Vec3(3.0F, 1.0F, -2.0F), Vec3(0.0F, 3.0F, 4.0F), 300};
    const Emitter e = emitter_of(shards(), burst);
    ASSERT_EQ(unfit(e), "");
    EXPECT_EQ(born_before(e, 40, 1.0 / 240.0), 0u);
    EXPECT_EQ(born_before(e, 41, 1.0 / 240.0), 300u);
    EXPECT_EQ(born_before(e, 4000, 1.0 / 240.0), 300u);
    float slowest = 100.0F;
    float fastest = 0.0F;
    for (std::uint64_t i = 0; i < 300; ++i) {
        const Birth birth = birth_of(e, i);
        const float speed = birth.velocity.norm();
        slowest = std::min(slowest, speed);
        fastest = std::max(fastest, speed);
        // A few roundings of floats in the unit vectors.
        EXPECT_GE(birth.velocity.dot(Vec3(0.0F, 0.6F, 0.8F)), (0.8F - 1e-5F) * speed);
        EXPECT_LE((birth.position - burst.position).norm(), 0.1F + 1e-5F);
        EXPECT_GE(birth.lifetime_s, 0.5F);
        EXPECT_LE(birth.lifetime_s, 2.0F);
    }
    // Uniform in [1.25, 5]: that none of 300 lies in an end of a tenth has a chance of 0.9^300.
    EXPECT_GE(slowest, 1.25F - 1e-5F);
    EXPECT_LT(slowest, 1.625F);
    EXPECT_LE(fastest, 5.0F + 1e-5F);
    EXPECT_GT(fastest, 4.625F);
}

TEST(Burst, WithoutAVelocityRestsAndPointsUp) {
    const Emitter e = emitter_of(shards(), Burst{1, 0, Vec3::Zero(), Vec3::Zero(), 3});
    EXPECT_EQ(unfit(e), "");
    EXPECT_EQ(e.direction, Vec3(Vec3::UnitY()));
    EXPECT_EQ(birth_of(e, 0).velocity.norm(), 0.0F);
}

TEST(Burst, ThatIsNotFiniteIsUnfit) {
    const float nan = std::numeric_limits<float>::quiet_NaN();
    const float infinite = std::numeric_limits<float>::infinity();
    for (const float bad : {nan, infinite, -infinite}) {
        Burst burst{1, 0, Vec3::Zero(), Vec3::UnitX(), 3};
        burst.position.y() = bad;
        EXPECT_NE(unfit(emitter_of(shards(), burst)), "") << bad;
        burst.position.y() = 0.0F;
        EXPECT_EQ(unfit(emitter_of(shards(), burst)), "");
        burst.velocity.z() = bad;
        EXPECT_NE(unfit(emitter_of(shards(), burst)), "") << bad;
    }
    // Its square is beyond the floats.
    EXPECT_NE(unfit(emitter_of(shards(), Burst{1, 0, Vec3::Zero(), Vec3(1e30F, 0.0F, 0.0F), 3})),
              "");
}

TEST(BurstKind, ThatMakesNoSenseIsRefusedWithAReason) {
    EXPECT_EQ(unfit(shards()), "");
    const auto why = [](auto&& spoil) {
        BurstKind kind = shards();
        spoil(kind);
        return unfit(kind);
    };
    EXPECT_NE(why([](auto& k) { k.slowest = 1.5F; }).find("slowest"), std::string::npos);
    EXPECT_NE(why([](auto& k) { k.slowest = NAN; }).find("slowest"), std::string::npos);
    EXPECT_NE(why([](auto& k) { k.cone_cosine = -1.5F; }).find("cone"), std::string::npos);
    EXPECT_NE(why([](auto& k) { k.spread = -1.0F; }).find("spread"), std::string::npos);
    EXPECT_NE(why([](auto& k) { k.lifetime_min_s = 0.0F; }).find("lifetime"), std::string::npos);
    EXPECT_NE(why([](auto& k) { k.lifetime_max_s = 0.1F; }).find("lifetime"), std::string::npos);
    EXPECT_NE(why([](auto& k) { k.lifetime_max_s = INFINITY; }).find("lifetime"),
              std::string::npos);
}

}  // namespace
}  // namespace zoned::motion
