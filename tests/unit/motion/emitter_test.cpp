#include "shared/motion/emitter.h"

#include <gtest/gtest.h>

#include <cmath>

namespace zoned::motion {
namespace {

constexpr double kTick = 1.0 / 30.0;

CosmeticEmitter smoke() {
    CosmeticEmitter c;
    c.emitter.seed = 99;
    c.emitter.start = 1000;
    c.emitter.rate_hz = 333.0;
    c.emitter.cone_cosine = 0.5F;
    c.emitter.speed_min = 1.0F;
    c.emitter.speed_max = 4.0F;
    c.emitter.lifetime_min_s = 0.5F;
    c.emitter.lifetime_max_s = 2.0F;
    c.drag = 0.7F;
    c.wind = Vec3(1.0F, 0.0F, 0.5F);
    return c;
}

TEST(Emitter, BearsRateTimesTimeAndNeverTheSameTwice) {
    Emitter e;
    e.rate_hz = 333.3;
    std::uint64_t born = 0;
    for (Tick t = 0; t < 30 * 60; ++t) {
        const std::uint64_t before = born_before(e, t, kTick);
        ASSERT_EQ(before, born);
        born = born_before(e, t + 1, kTick);
        ASSERT_GE(born, before);
    }
    EXPECT_NEAR(static_cast<double>(born), 333.3 * 60.0, 1.0);
    e.most = 10;
    EXPECT_EQ(born_before(e, 1'000'000, kTick), 10U);
    EXPECT_EQ(born_before(e, e.start, kTick), 0U);
}

TEST(Emitter, KeepsToConeAndSpeedsAndFillsTheConeEvenly) {
    Emitter e = smoke().emitter;
    e.direction = Vec3(0.6F, 0.0F, 0.8F);
    double mean = 0.0;
    const int count = 20'000;
    for (int i = 0; i < count; ++i) {
        const Birth b = birth_of(e, static_cast<std::uint64_t>(i));
        const float speed = b.velocity.norm();
        ASSERT_GE(speed, 1.0F - 1e-5F);
        ASSERT_LE(speed, 4.0F + 1e-5F);
        const float cosine = b.velocity.dot(e.direction) / speed;
        ASSERT_GE(cosine, 0.5F - 1e-5F);
        mean += static_cast<double>(cosine) / count;
    }
    // The cosine is uniform in [0.5, 1]: mean 0.75, standard deviation of the mean 0.144 / sqrt(n).
    EXPECT_NEAR(mean, 0.75, 5.0 * 0.144 / std::sqrt(count));
}

TEST(Replay, GivesTheSameForWhoeverComesWhenever) {
    const CosmeticEmitter c = smoke();
    std::vector<CosmeticParticle> always, late;
    for (Tick t = 1000; t <= 1200; ++t) {
        always.clear();
        replay(c, t, kTick, always);
    }
    replay(c, 1200, kTick, late);
    ASSERT_EQ(always.size(), late.size());
    EXPECT_NEAR(static_cast<double>(late.size()), 333.0 * 1.25, 60.0);
    for (std::size_t i = 0; i < late.size(); ++i) {
        EXPECT_EQ(always[i].index, late[i].index);
        EXPECT_EQ(always[i].position, late[i].position);
        EXPECT_LT(late[i].age_share, 1.0F);
    }
    late.clear();
    replay(c, 999, kTick, late);
    EXPECT_TRUE(late.empty());
}

/// Against small steps of the same equation in doubles: second order, a step of 1e-4 s leaves
/// some 1e-8 m, a float's last bit of some metres is 5e-7 m.
TEST(Replay, FollowsTheEquationOfMotion) {
    for (const float drag : {0.0F, 1e-9F, 0.7F, 20.0F}) {
        CosmeticEmitter c = smoke();
        c.drag = drag;
        c.emitter.most = 1;
        c.emitter.lifetime_min_s = 2.0F;
        std::vector<CosmeticParticle> sparks;
        replay(c, 1000 + 45, kTick, sparks);
        ASSERT_EQ(sparks.size(), 1U);
        const Birth birth = birth_of(c.emitter, 0);
        Vec3d x = birth.position.cast<double>();
        Vec3d v = birth.velocity.cast<double>();
        const double h = 1e-4;
        const auto pull = [&](const Vec3d& u) {
            return Vec3d(c.gravity.cast<double>() -
                         static_cast<double>(drag) * (u - c.wind.cast<double>()));
        };
        for (int i = 0; i < 15'000; ++i) {
            const Vec3d middle = v + 0.5 * h * pull(v);
            v += h * pull(middle);
            x += h * middle;
        }
        EXPECT_LT((sparks[0].position.cast<double>() - x).norm(), 5e-6) << drag;
        EXPECT_LT((sparks[0].velocity.cast<double>() - v).norm(), 5e-6) << drag;
    }
}

}  // namespace
}  // namespace zoned::motion
