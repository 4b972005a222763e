#include "server/replication/motion_estimate.h"

#include "server/replication/landing.h"
#include "server/replication/volatility.h"
#include "shared/core/rng.h"
#include "shared/motion/dead_reckoning.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>

namespace zoned::replication {
namespace {

constexpr float kTick = 1.0F / 30.0F;
using Path = std::function<motion::KinematicState(float)>;

MotionEstimate observed(const Path& path, int ticks) {
    MotionEstimate estimate;
    for (Tick t = 1; t <= ticks; ++t) {
        estimate.observe(t, 0, path(static_cast<float>(t) * kTick), {});
    }
    return estimate;
}

/// Around a centre that drifts: radius 4 m, at `w` about +y.
motion::KinematicState on_circle(float w, float t) {
    const Vec3 n = Vec3::UnitY();
    const Vec3 r = Eigen::AngleAxisf(w * t, n) * Vec3(4.0F, 0.0F, 0.0F);
    const Vec3 drift(3.0F, 0.5F, -1.0F);
    motion::KinematicState state;
    state.position = r + drift * t;
    state.velocity = drift + w * n.cross(r);
    state.acceleration = -w * w * r;
    return state;
}

TEST(MotionEstimate, FindsTheTurnOfACircleAboutACentreThatDrifts) {
    for (const float w : {-6.0F, -1.0F, 0.3F, 2.0F, 8.0F}) {
        const MotionEstimate e = observed([&](float t) { return on_circle(w, t); }, 20);
        ASSERT_TRUE(e.turns()) << w;
        const motion::KinematicState now = on_circle(w, 20.0F * kTick);
        // Velocities of some 10 to 35 m/s round to 2e-6 m/s. Over a window of 0.13 s that is 2e-5
        // m/s2 of w^2 4 m, and the same share of an angle. Positions of the turn round a little
        // more.
        const float share = 1e-4F + 1e-3F / (w * w);
        EXPECT_LT((e.turn() - Vec3(0.0F, w, 0.0F)).norm(), share * std::abs(w)) << w;
        EXPECT_LT((e.acceleration() - now.acceleration).norm(), share * now.acceleration.norm());
        EXPECT_FALSE(e.falls());
    }
}

TEST(MotionEstimate, FindsNoTurnWhereNothingTurns) {
    const auto straight = [](float t) {
        motion::KinematicState s;
        s.velocity = Vec3(3.0F, 0.0F, 4.0F);
        s.position = s.velocity * t;
        return s;
    };
    EXPECT_FALSE(observed(straight, 20).turns());
    const auto speeding = [](float t) {
        motion::KinematicState s;
        s.velocity = Vec3(3.0F, 0.0F, 4.0F) * t;
        s.position = Vec3(1.5F, 0.0F, 2.0F) * t * t;
        return s;
    };
    EXPECT_FALSE(observed(speeding, 20).turns());
    // A corner: straight, a tick of another velocity, straight again.
    const auto corner = [&](float t) {
        motion::KinematicState s = straight(t);
        if (t > 10.5F * kTick) {
            s.velocity = Vec3(4.0F, 0.0F, -3.0F);
        }
        return s;
    };
    for (int ticks = 1; ticks < 30; ++ticks) {
        EXPECT_FALSE(observed(corner, ticks).turns()) << ticks;
    }
}

TEST(MotionEstimate, BeginsAnewAfterAGapOrADiscontinuity) {
    MotionEstimate e = observed([&](float t) { return on_circle(2.0F, t); }, 20);
    ASSERT_TRUE(e.turns());
    e.observe(22, 0, on_circle(2.0F, 22.0F * kTick), {});
    EXPECT_FALSE(e.turns());
    e = observed([&](float t) { return on_circle(2.0F, t); }, 20);
    e.observe(21, 21, on_circle(2.0F, 21.0F * kTick), {});
    EXPECT_FALSE(e.turns());
    EXPECT_EQ(e.centring(), Vec3(Vec3::Zero()));
}

/// Free fall as a simulation takes it: semi-implicit Euler in `substeps` per tick.
motion::KinematicState fallen(int ticks, int substeps) {
    motion::KinematicState s;
    s.velocity = Vec3(2.0F, 6.0F, 0.0F);
    const float h = kTick / static_cast<float>(substeps);
    for (int i = 0; i < ticks * substeps; ++i) {
        s.velocity.y() -= kGravity * h;
        s.position += s.velocity * h;
    }
    return s;
}

TEST(MotionEstimate, TheCentredVelocityLeadsTheParabolaThroughTheStepsOfTheSimulation) {
    for (const int substeps : {1, 2, 8}) {
        MotionEstimate e;
        for (Tick t = 1; t <= 5; ++t) {
            e.observe(t, 0, fallen(static_cast<int>(t), substeps), {});
        }
        EXPECT_TRUE(e.falls());
        motion::KinematicState from = fallen(5, substeps);
        from.velocity += e.centring();
        from.acceleration = Vec3(0.0F, -kGravity, 0.0F);
        for (const int later : {5, 15, 30}) {
            const Vec3 predicted = motion::predict_position(
                from, motion::PredictorOrder::kBallistic, static_cast<float>(later) * kTick);
            // Exact but for rounding: positions of up to 5 m in up to 280 additions.
            EXPECT_LT((predicted - fallen(5 + later, substeps).position).norm(), 2e-4F);
        }
    }
}

TEST(MotionEstimate, APushIsNotTakenForAWayOfIntegrating) {
    MotionEstimate e;
    motion::KinematicState s;
    e.observe(1, 0, s, {});
    s.position = Vec3(0.1F, 0.0F, 0.0F);  // 3 m/s that no velocity shows
    s.velocity = Vec3(0.0F, 0.1F, 0.0F);
    e.observe(2, 0, s, {});
    EXPECT_EQ(e.centring(), Vec3(Vec3::Zero()));
}

world::EntityType ball() {
    world::EntityType type;
    type.shape = world::TypeShape::kSphere;
    type.radius = 0.25F;
    return type;
}

TEST(Landing, IsOnTheTopmostSolidUnderThePath) {
    motion::StaticBox table;
    table.centre = Vec3(5.0F, 1.0F, 0.0F);
    table.half_extents = Vec3(1.0F, 0.1F, 1.0F);
    motion::StaticBox roof = table;
    roof.centre.y() = 6.0F;
    const motion::StaticGeometry ground({table, roof}, 0.5F);
    const float height = resting_height(ball(), Quat::Identity());
    motion::KinematicState from;
    from.acceleration = Vec3(0.0F, -kGravity, 0.0F);
    // Beside both, on the table under the roof, on the roof, off the table's edge by its speed.
    from.position = Vec3(0.0F, 3.0F, 0.0F);
    EXPECT_NEAR(landing_height(ground, from, height), 0.75F, 1e-5F);
    from.position = Vec3(5.0F, 3.0F, 0.0F);
    EXPECT_NEAR(landing_height(ground, from, height), 1.35F, 1e-5F);
    from.position = Vec3(5.0F, 9.0F, 0.0F);
    EXPECT_NEAR(landing_height(ground, from, height), 6.35F, 1e-5F);
    from.position = Vec3(5.0F, 3.0F, 0.0F);
    from.velocity = Vec3(5.0F, 0.0F, 0.0F);
    EXPECT_NEAR(landing_height(ground, from, height), 0.75F, 1e-5F);
    // Three seconds are not enough for 60 m.
    from.position = Vec3(0.0F, 60.0F, 0.0F);
    EXPECT_TRUE(std::isinf(landing_height(ground, from, height)));
}

TEST(Landing, ABoxRestsOnTheSideThatLooksDownMost) {
    world::EntityType box;
    box.shape = world::TypeShape::kBox;
    box.half_extents = Vec3(0.2F, 0.5F, 1.0F);
    EXPECT_FLOAT_EQ(resting_height(box, Quat::Identity()), 0.5F);
    EXPECT_FLOAT_EQ(resting_height(box, Quat(Eigen::AngleAxisf(1.5F, Vec3::UnitX()))), 1.0F);
    EXPECT_FLOAT_EQ(resting_height(box, Quat(Eigen::AngleAxisf(-1.4F, Vec3::UnitZ()))), 0.2F);
}

/// Publications that the least volatile kind needs for ten seconds of a path, and which it is.
struct Outcome {
    int publications = 0;
    std::array<int, motion::kPredictorOrders> by_kind{};
};

Outcome follow(const Path& path, int forced, int ticks) {
    ReplicationSettings settings;
    settings.lods = {{}};
    const world::EntityType type = ball();
    MotionEstimate estimate;
    Volatility volatility;
    motion::KinematicState from = path(kTick);
    motion::PredictorOrder kind = motion::PredictorOrder::kLinear;
    Tick published = 1;
    volatility.restart(1, from);
    Outcome out;
    for (Tick t = 1; t <= ticks; ++t) {
        Truth truth{path(static_cast<float>(t) * kTick), &estimate, &type};
        estimate.observe(t, 0, truth.state, {});
        truth.state.velocity += estimate.centring();
        volatility.observe(t, truth, false, settings.lods[0], settings.quantization, settings);
        const float elapsed = elapsed_seconds(published, t, kTick);
        if (t == 1 || leaves_bound(from, kind, elapsed, truth.state, settings.lods[0])) {
            kind = forced < 0 ? volatility.best()
                              : fitting(estimate, static_cast<motion::PredictorOrder>(forced));
            from = wire::dequantize(
                wire::quantize(
                    start_of(truth, kind, settings), kind, false, false, 0, settings.quantization),
                false,
                settings.quantization);
            published = t;
            ++out.publications;
            ++out.by_kind[static_cast<std::size_t>(kind)];
        }
    }
    return out;
}

TEST(Volatility, ChoosesTurningForWhatGoesRoundAndNeedsFarFewerPublications) {
    const Path circle = [](float t) {
        return on_circle(1.5F, t);
    };
    const Outcome best = follow(circle, -1, 300);
    const Outcome order_two = follow(circle, 2, 300);
    // Order 2 leaves 0.05 m when |a| w t^3 / 6 = 0.05: after 0.28 s, 35 times in ten seconds.
    EXPECT_GT(order_two.publications, 25);
    EXPECT_LT(3 * best.publications, order_two.publications);
    EXPECT_GT(best.by_kind[4], 0);
}

TEST(Volatility, ChoosesBallisticForWhatFalls) {
    const Path fall = [](float t) {
        return fallen(static_cast<int>(std::lround(t / kTick)), 1);
    };
    const Outcome best = follow(fall, -1, 30);
    EXPECT_LE(best.publications, 3);
    EXPECT_GE(best.by_kind[3], 1);
    EXPECT_GT(follow(fall, 1, 30).publications, 5);
}

TEST(Volatility, StaysWithOrderOneForWhatGoesStraight) {
    const Path straight = [](float t) {
        motion::KinematicState s;
        s.velocity = Vec3(3.0F, 0.0F, 4.0F);
        s.position = s.velocity * t;
        return s;
    };
    const Outcome best = follow(straight, -1, 300);
    EXPECT_EQ(best.by_kind[1], best.publications);
}

}  // namespace
}  // namespace zoned::replication
