// build: computes
#include "shared/wire/quantize.h"

#include "tests/unit/wire/wire_samples.h"

#include <gtest/gtest.h>

#include <limits>
#include <numbers>

namespace zoned::wire {
namespace {

using motion::KinematicState;
using motion::PredictorOrder;
using testing::quantizations;
using testing::random_motion;
using testing::random_quantized;

QuantizedState again(const QuantizedState& s, bool upright, const Quantization& q) {
    return quantize(dequantize(s, upright, q), s.order, upright, s.at_rest, s.appearance, q);
}

/// Angle in double: a float's arc cosine would be off by a tenth of the bound of 15 bits.
double angle_of(const Quat& a, const Quat& b) {
    const Eigen::Quaterniond x = Eigen::Quaterniond(a.w(), a.x(), a.y(), a.z()).normalized();
    const Eigen::Quaterniond y = Eigen::Quaterniond(b.w(), b.x(), b.y(), b.z()).normalized();
    return x.angularDistance(y);
}

TEST(Quantize, SurvivesTheRoundTripOnIntegersForRandomStates) {
    core::Rng rng(1);
    for (const Quantization& q : quantizations()) {
        for (int i = 0; i < 200'000; ++i) {
            const bool upright = (i & 1) != 0;
            const QuantizedState s = random_quantized(rng, upright, q);
            ASSERT_EQ(again(s, upright, q), s) << "sample " << i;
        }
    }
}

TEST(Quantize, SurvivesTheRoundTripForEveryOrientationOfFiveBits) {
    Quantization q;
    q.orientation_bits = 5;
    const std::int32_t limit = limits_of(q).orientation;
    int canonical = 0;
    for (std::int32_t largest = 0; largest < 4; ++largest) {
        for (std::int32_t a = -limit; a <= limit; ++a) {
            for (std::int32_t b = -limit; b <= limit; ++b) {
                for (std::int32_t c = -limit; c <= limit; ++c) {
                    QuantizedState s;
                    s.orientation_largest = largest;
                    s.orientation = {a, b, c};
                    if (is_canonical_orientation(largest, s.orientation, limit)) {
                        ++canonical;
                        ASSERT_EQ(again(s, false, q), s)
                            << largest << ": " << a << " " << b << " " << c;
                    }
                }
            }
        }
    }
    // A chart holds the points of the cube |x|, |y|, |z| <= limit whose fourth component is greater
    // still; it contains the cube of 1 / sqrt 2 of that edge, (sqrt 2 limit)^3 = 2.8 limit^3. Fewer
    // forms would mean that rounding is coarser than promised.
    EXPECT_GT(canonical, 4 * 2.8 * limit * limit * limit);
}

TEST(Quantize, SurvivesTheRoundTripWhereSeveralComponentsAreNearlyTheLargest) {
    core::Rng rng(2);
    for (const int bits : {5, 6, 8, 10, 12, 15}) {
        Quantization q;
        q.orientation_bits = bits;
        const double unit = 1.0 / (limits_of(q).orientation * std::numbers::sqrt2);
        for (int i = 0; i < 170'000; ++i) {
            // Two to four components of equal magnitude, shaken by up to three units.
            Eigen::Vector4f v = Eigen::Vector4f::Zero();
            const std::uint32_t equal = 2 + rng.below(3);
            const std::uint32_t start = rng.below(4);
            for (std::uint32_t j = 0; j < equal; ++j) {
                v[(start + j) % 4] = rng.below(2) != 0 ? 1.0F : -1.0F;
            }
            v.normalize();
            const float shake = rng.below(4) == 0 ? 0.0F : static_cast<float>(3 * unit);
            for (int j = 0; j < 4; ++j) {
                v[j] += rng.range(-shake, shake);
            }
            v.normalize();
            KinematicState state;
            state.orientation = Quat(v[0], v[1], v[2], v[3]);
            const auto s = quantize(state, PredictorOrder::kStatic, false, false, 0, q);
            ASSERT_TRUE(is_canonical_orientation(
                s.orientation_largest, s.orientation, limits_of(q).orientation));
            ASSERT_EQ(again(s, false, q), s);
            ASSERT_LE(angle_of(state.orientation, dequantize(s, false, q).orientation),
                      q.orientation_quantum_rad(false));
        }
    }
}

TEST(Quantize, GivesOppositeQuaternionsTheSameIntegers) {
    core::Rng rng(3);
    const Quantization q;
    for (int i = 0; i < 100'000; ++i) {
        KinematicState a;
        a.orientation = testing::random_rotation(rng);
        KinematicState b = a;
        b.orientation.coeffs() = -a.orientation.coeffs();
        for (const bool upright : {false, true}) {
            ASSERT_EQ(quantize(a, PredictorOrder::kStatic, upright, false, 0, q),
                      quantize(b, PredictorOrder::kStatic, upright, false, 0, q));
        }
    }
}

TEST(Quantize, KeepsPositionsAndOrientationsWithinTheDeclaredQuanta) {
    core::Rng rng(4);
    for (const Quantization& q : quantizations()) {
        double worst_m = 0.0;
        double worst_rad = 0.0;
        double worst_yaw = 0.0;
        for (int i = 0; i < 200'000; ++i) {
            KinematicState s;
            s.position = Vec3(rng.range(-q.horizontal_extent_m, q.horizontal_extent_m),
                              rng.range(-q.vertical_extent_m, q.vertical_extent_m),
                              rng.range(-q.horizontal_extent_m, q.horizontal_extent_m));
            s.orientation = testing::random_rotation(rng);
            const KinematicState back =
                dequantize(quantize(s, PredictorOrder::kLinear, false, false, 0, q), false, q);
            worst_m = std::max<double>(
                worst_m, (s.position.cast<double>() - back.position.cast<double>()).norm());
            worst_rad = std::max(worst_rad, angle_of(s.orientation, back.orientation));

            const float half = rng.range(-4.0F, 4.0F);
            s.orientation = Quat(std::cos(half), 0.0F, std::sin(half), 0.0F);
            const KinematicState turned =
                dequantize(quantize(s, PredictorOrder::kLinear, true, false, 0, q), true, q);
            worst_yaw = std::max(worst_yaw, angle_of(s.orientation, turned.orientation));
        }
        EXPECT_LE(worst_m, q.position_quantum_m());
        EXPECT_LE(worst_rad, q.orientation_quantum_rad(false));
        EXPECT_LE(worst_yaw, q.orientation_quantum_rad(true));
        // The bounds are not idle: random samples come near to them (less so where the steps are as
        // fine as floats, because few samples lie at the rim).
        EXPECT_GT(worst_m, 0.6 * q.position_quantum_m());
        EXPECT_GT(worst_rad, 0.45 * q.orientation_quantum_rad(false));
        EXPECT_GT(worst_yaw, 0.9 * q.orientation_quantum_rad(true));
    }
}

TEST(Quantize, TurnsNumbersThatAreNoneIntoDefinedValues) {
    const Quantization q;
    const QuantizationLimits limits = limits_of(q);
    const float nan = std::numeric_limits<float>::quiet_NaN();
    const float inf = std::numeric_limits<float>::infinity();
    KinematicState s;
    s.position = Vec3(nan, inf, -inf);
    s.velocity = Vec3(inf, nan, -inf);
    s.acceleration = Vec3(-inf, inf, nan);
    s.angular_velocity = Vec3(nan, inf, -inf);
    s.orientation = Quat(nan, 0, 0, 0);
    for (const bool upright : {false, true}) {
        const auto out = quantize(s, PredictorOrder::kQuadratic, upright, false, 0, q);
        EXPECT_EQ(out.position, (std::array{0, limits.vertical, -limits.horizontal}));
        EXPECT_EQ(out.velocity, (std::array{limits.velocity, 0, -limits.velocity}));
        EXPECT_EQ(out.acceleration, (std::array{-limits.acceleration, limits.acceleration, 0}));
        EXPECT_EQ(out.angular_velocity,
                  (std::array{0, limits.angular_velocity, upright ? 0 : -limits.angular_velocity}));
        EXPECT_EQ(out.orientation, (std::array{0, 0, 0}));
        EXPECT_EQ(out.orientation_largest, 0);
        EXPECT_EQ(again(out, upright, q), out);
    }
    for (const Quat& odd : {Quat(0, 0, 0, 0), Quat(inf, 0, 0, 0), Quat(0, nan, 1, 0)}) {
        s.orientation = odd;
        const auto out = quantize(s, PredictorOrder::kStatic, false, false, 0, q);
        EXPECT_EQ(out.orientation, (std::array{0, 0, 0}));
    }
}

TEST(Quantize, ClampsToTheExtents) {
    const Quantization q;
    KinematicState s;
    s.position = Vec3(1e9F, -1e9F, 2048.004F);
    s.velocity = Vec3(300.0F, -300.0F, 0.0F);
    const auto back = dequantize(quantize(s, PredictorOrder::kLinear, true, false, 0, q), true, q);
    EXPECT_NEAR(back.position.x(), 2048.0F, q.position_quantum_m());
    EXPECT_NEAR(back.position.y(), -1024.0F, q.position_quantum_m());
    EXPECT_NEAR(back.position.z(), 2048.0F, q.position_quantum_m());
    EXPECT_EQ(back.velocity, Vec3(256.0F, -256.0F, 0.0F));
}

TEST(Quantize, LeavesOutWhatTheOrderDoesNotPredictWith) {
    core::Rng rng(5);
    const Quantization q;
    KinematicState s = random_motion(rng, q);
    s.velocity = s.acceleration = s.angular_velocity = Vec3(3.0F, 4.0F, 5.0F);
    constexpr std::array<std::int32_t, 3> kZero{};
    const auto still = quantize(s, PredictorOrder::kStatic, false, true, 0, q);
    EXPECT_EQ(still.velocity, kZero);
    EXPECT_EQ(still.acceleration, kZero);
    EXPECT_EQ(still.angular_velocity, kZero);
    EXPECT_FALSE(still.at_rest) << "it moves, whatever the caller believes";
    const auto linear = quantize(s, PredictorOrder::kLinear, false, true, 0, q);
    EXPECT_NE(linear.velocity, kZero);
    EXPECT_EQ(linear.acceleration, kZero);
    EXPECT_NE(linear.angular_velocity, kZero);
    EXPECT_FALSE(linear.at_rest);
    const auto quadratic = quantize(s, PredictorOrder::kQuadratic, true, false, 0, q);
    EXPECT_NE(quadratic.acceleration, kZero);
    EXPECT_EQ(quadratic.angular_velocity, (std::array{0, 128, 0}));
    s.velocity = s.angular_velocity = Vec3::Zero();
    EXPECT_TRUE(quantize(s, PredictorOrder::kStatic, false, true, 0, q).at_rest);
    EXPECT_FALSE(quantize(s, PredictorOrder::kStatic, false, false, 0, q).at_rest);
}

TEST(Quantize, AgreesWithCommandsAboutWhichWayAYawTurns) {
    Quantization q;
    q.yaw_bits = 16;
    for (const std::int32_t yaw : {0, 1, 100, 16384, 32767, 32768, 49152, 65535}) {
        const double angle = 2.0 * std::numbers::pi * yaw / 65536.0;
        KinematicState s;
        s.orientation = Quat(Eigen::AngleAxisf(static_cast<float>(angle), Vec3::UnitY()));
        EXPECT_EQ(quantize(s, PredictorOrder::kStatic, true, false, 0, q).orientation[0], yaw);
    }
}

TEST(RateSteps, TakeNoMoreThanAQuarterOfTheBoundOverTheHorizon) {
    for (const float bound : {0.001F, 0.01F, 0.05F, 0.3F, 2.0F}) {
        for (const float horizon : {0.1F, 0.5F, 1.0F, 2.0F}) {
            const RateSteps s = rate_steps(bound, 2.0F * bound, horizon);
            // Where the range of steps does not forbid it.
            if (s.velocity_mps > 0x1p-10F) {
                EXPECT_LE(0.5F * s.velocity_mps * horizon, 0.25F * bound);
            }
            if (s.acceleration_mps2 > 0x1p-8F) {
                EXPECT_LE(0.25F * s.acceleration_mps2 * horizon * horizon, 0.25F * bound);
            }
            if (s.angular_velocity_rps > 0x1p-10F) {
                EXPECT_LE(0.5F * s.angular_velocity_rps * horizon, 0.5F * bound);
            }
            // And not less than half of that, but for the coarsest.
            if (s.velocity_mps < 1.0F) {
                EXPECT_GE(s.velocity_mps * horizon, 0.25F * bound);
            }
            if (s.acceleration_mps2 < 8.0F) {
                EXPECT_GE(s.acceleration_mps2 * horizon * horizon, 0.5F * bound);
            }
        }
    }
}

TEST(RateSteps, OfTheDefaultWorldAreThoseOfTheDefaultQuantization) {
    const RateSteps s = rate_steps(0.05F, 0.1F, 1.0F);
    const Quantization q;
    EXPECT_EQ(s.velocity_mps, q.velocity_step_mps);
    EXPECT_EQ(s.acceleration_mps2, q.acceleration_step_mps2);
    EXPECT_EQ(s.angular_velocity_rps, q.angular_velocity_step_rps);
}

}  // namespace
}  // namespace zoned::wire
