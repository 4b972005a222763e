// build: computes
#include "shared/motion/apply_input.h"

#include "shared/core/rng.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <vector>

namespace zoned::motion {
namespace {

constexpr float kDt = 1.0F / 30.0F;
constexpr CharacterLimits kLimits;
constexpr float kStand = kLimits.radius + kLimits.half_segment;

const StaticGeometry& flat_world() {
    static const StaticGeometry world({}, 0.0F);
    return world;
}

CharacterState standing_at(float x, float y, float z) {
    CharacterState state;
    state.position = Vec3(x, y + kStand, z);
    state.grounded = true;
    return state;
}

InputCommand go(int x, int z, std::uint16_t buttons = 0) {
    InputCommand command;
    command.move_x = static_cast<std::int8_t>(x);
    command.move_z = static_cast<std::int8_t>(z);
    command.buttons = buttons;
    return command;
}

CharacterState run(CharacterState state,
                   const InputCommand& command,
                   const StaticGeometry& world,
                   int ticks,
                   const CharacterLimits& limits = kLimits) {
    for (int i = 0; i < ticks; ++i) {
        state = apply_input(state, command, limits, world, kDt);
    }
    return state;
}

StaticBox box(const Vec3& centre, const Vec3& half, const Quat& orientation = Quat::Identity()) {
    StaticBox b;
    b.centre = centre;
    b.half_extents = half;
    b.orientation = orientation;
    return b;
}

float radians(float degrees) {
    return degrees * std::numbers::pi_v<float> / 180.0F;
}

/// A large plane slab through the origin that rises towards +x by `degrees`.
StaticGeometry slope_world(float degrees) {
    const Quat turn(Eigen::AngleAxisf(radians(degrees), Vec3::UnitZ()));
    return StaticGeometry({box(turn * Vec3(0.0F, -1.0F, 0.0F), Vec3(50.0F, 1.0F, 50.0F), turn)},
                          -100.0F);
}

/// Lets a character fall onto the world at (x, z) from `height`, and waits until it rests.
CharacterState landed(const StaticGeometry& world, float x, float height, float z) {
    CharacterState state;
    state.position = Vec3(x, height, z);
    return run(state, go(0, 0), world, 150);
}

/// Distance between the capsule's segment and a box by golden section in double: independent of the
/// code under test.
double axis_distance(const Vec3& position, const StaticBox& b) {
    const Eigen::Matrix3d axes = b.orientation.cast<double>().toRotationMatrix();
    const auto at = [&](double y) {
        Vec3d p = position.cast<double>();
        p.y() += y;
        const Vec3d local = axes.transpose() * (p - b.centre.cast<double>());
        const Vec3d h = b.half_extents.cast<double>();
        return (local - local.cwiseMax(-h).cwiseMin(h)).norm();
    };
    double lo = -kLimits.half_segment;
    double hi = kLimits.half_segment;
    const double g = 1.0 / std::numbers::phi;
    for (int i = 0; i < 40; ++i) {
        const double a = hi - g * (hi - lo);
        const double c = lo + g * (hi - lo);
        (at(a) < at(c) ? hi : lo) = at(a) < at(c) ? c : a;
    }
    return std::min({at(lo), at(-kLimits.half_segment), at(kLimits.half_segment)});
}

/// How deep the capsule is inside the worst box or the ground, m (negative: free).
double penetration(const Vec3& position, const StaticGeometry& world) {
    double worst = static_cast<double>(world.ground_height()) + kStand - position.y();
    const Aabb near = Aabb{position, position}.grown(kStand + 0.1F);
    world.for_each_near(near, [&](std::uint32_t i) {
        worst = std::max(worst, kLimits.radius - axis_distance(position, world.boxes()[i]));
    });
    return worst;
}

bool same_bits(const Vec3& a, const Vec3& b) {
    for (int i = 0; i < 3; ++i) {
        if (std::bit_cast<std::uint32_t>(a[i]) != std::bit_cast<std::uint32_t>(b[i])) {
            return false;
        }
    }
    return true;
}

TEST(ApplyInput, FullInputReachesFullSpeedExactlyAndAtTheGivenAcceleration) {
    CharacterState state = standing_at(0, 0, 0);
    const InputCommand command = go(127, 0);
    // 20 m/s2 for 0.25 s makes 5 m/s; the distance until then is a t^2 / 2, afterwards v t.
    for (int i = 1; i <= 30; ++i) {
        state = apply_input(state, command, kLimits, flat_world(), kDt);
        const double t = i * static_cast<double>(kDt);
        const double ramp = std::min(t, 0.25);
        EXPECT_NEAR(state.velocity.x(), 20.0 * ramp, 1e-5);
        EXPECT_NEAR(state.position.x(), 10.0 * ramp * ramp + 5.0 * (t - ramp), 1e-5);
    }
    EXPECT_EQ(state.velocity, Vec3(kLimits.speed, 0.0F, 0.0F));
    EXPECT_EQ(state.position.y(), kStand);
    const CharacterState sprint = run(state, go(0, -127, kButtonSprint), flat_world(), 60);
    EXPECT_EQ(sprint.velocity, Vec3(0.0F, 0.0F, -kLimits.speed * kLimits.sprint_factor));
}

TEST(ApplyInput, DiagonalInputIsNoFasterThanStraightInput) {
    const CharacterState state = run(standing_at(0, 0, 0), go(127, -127), flat_world(), 60);
    EXPECT_NEAR(state.velocity.norm(), kLimits.speed, 1e-5F);
    EXPECT_EQ(state.velocity.x(), -state.velocity.z());
}

TEST(ApplyInput, HalfInputWalksAtHalfSpeed) {
    const CharacterState state = run(standing_at(0, 0, 0), go(0, 64), flat_world(), 60);
    EXPECT_FLOAT_EQ(state.velocity.z(), kLimits.speed * 64.0F / 127.0F);
}

TEST(ApplyInput, StopsWithExactlyZeroVelocityAndThenKeepsEveryBit) {
    CharacterState state = run(standing_at(0, 0, 0), go(100, 37), flat_world(), 30);
    state = run(state, go(0, 0), flat_world(), 15);
    EXPECT_TRUE(state.velocity.isZero(0.0F));
    EXPECT_TRUE(state.grounded);
    const CharacterState later = run(state, go(0, 0), flat_world(), 1000);
    EXPECT_TRUE(same_bits(later.position, state.position));
    EXPECT_TRUE(same_bits(later.velocity, state.velocity));
}

TEST(ApplyInput, JumpReachesTheHeightOfTheParabola) {
    CharacterState state =
        apply_input(standing_at(0, 0, 0), go(0, 0, kButtonJump), kLimits, flat_world(), kDt);
    EXPECT_FALSE(state.grounded);
    float apex = state.position.y();
    int ticks = 1;
    while (!state.grounded && ticks < 300) {
        state = apply_input(state, go(0, 0), kLimits, flat_world(), kDt);
        apex = std::max(apex, state.position.y());
        ++ticks;
    }
    // The parabola is sampled exactly, at most half a tick from the apex: v^2 / 2g less at most
    // g (dt / 2)^2 / 2.
    const double height = kLimits.jump_speed * kLimits.jump_speed / (2.0 * kLimits.gravity);
    EXPECT_LE(apex - kStand, height + 1e-5);
    EXPECT_GE(apex - kStand, height - kLimits.gravity * kDt * kDt / 8.0 - 1e-5);
    // Flight time 2 v / g, rounded up to a tick.
    EXPECT_EQ(ticks, static_cast<int>(std::ceil(2.0 * kLimits.jump_speed / kLimits.gravity / kDt)));
    EXPECT_EQ(state.position.y(), kStand);
    EXPECT_TRUE(state.velocity.isZero(0.0F));
}

TEST(ApplyInput, DoesNotJumpInTheAir) {
    CharacterState state;
    state.position = Vec3(0.0F, 10.0F, 0.0F);
    state = apply_input(state, go(0, 0, kButtonJump), kLimits, flat_world(), kDt);
    EXPECT_LT(state.velocity.y(), 0.0F);
}

TEST(ApplyInput, FallsOnTheExactParabola) {
    CharacterState state;
    state.position = Vec3(0.0F, 50.0F, 0.0F);
    state = run(state, go(0, 0), flat_world(), 60);
    EXPECT_NEAR(state.position.y(), 50.0 - 0.5 * kLimits.gravity * 4.0, 1e-4);
    EXPECT_NEAR(state.velocity.y(), -2.0 * kLimits.gravity, 1e-4);
}

TEST(ApplyInput, StandsOnEverySlopeThatCarriesWithoutMovingOneBit) {
    for (const float degrees : {1.0F, 10.0F, 30.0F, 45.0F, 50.0F}) {
        const StaticGeometry world = slope_world(degrees);
        const CharacterState state = landed(world, 0.3F, 2.0F, 0.7F);
        ASSERT_TRUE(state.grounded) << degrees;
        ASSERT_TRUE(state.velocity.isZero(0.0F)) << degrees;
        const CharacterState later = run(state, go(0, 0), world, 1000);
        EXPECT_TRUE(same_bits(later.position, state.position)) << degrees;
        EXPECT_LE(penetration(state.position, world), 0.0) << degrees;
        EXPECT_GE(penetration(state.position, world), -0.0015) << degrees;
    }
}

TEST(ApplyInput, SlidesDownASlopeThatDoesNotCarry) {
    for (const float degrees : {52.0F, 60.0F, 80.0F}) {
        const StaticGeometry world = slope_world(degrees);
        CharacterState state;
        state.position = Vec3(0.0F, 3.0F, 0.0F);
        state = run(state, go(0, 0), world, 120);
        EXPECT_FALSE(state.grounded) << degrees;
        EXPECT_LT(state.velocity.y(), -5.0F) << degrees;
        EXPECT_LT(state.position.y(), -5.0F) << degrees;
        EXPECT_LE(penetration(state.position, world), 0.0) << degrees;
    }
}

TEST(ApplyInput, WalksUpAndDownASlopeAtItsHorizontalSpeedWithoutLeavingTheGround) {
    const StaticGeometry world = slope_world(40.0F);
    for (const int direction : {127, -127}) {
        CharacterState state = landed(world, 0.0F, 2.0F, 0.0F);
        for (int i = 0; i < 60; ++i) {
            const float before = state.position.y();
            state = apply_input(state, go(direction, 0), kLimits, world, kDt);
            ASSERT_TRUE(state.grounded) << direction << " tick " << i;
            ASSERT_LE(penetration(state.position, world), 0.0);
            ASSERT_GE(penetration(state.position, world), -0.0015);
            if (i > 10) {
                EXPECT_FLOAT_EQ(std::abs(state.velocity.x()), kLimits.speed);
                // The vertical velocity is the true rate, within the variation that the skin
                // permits.
                EXPECT_NEAR((state.position.y() - before) / kDt, state.velocity.y(), 0.001F / kDt);
            }
        }
    }
}

TEST(ApplyInput, FollowsGroundThatEndsInALowDropAndFallsFromAHighOne) {
    const StaticGeometry low({box(Vec3(0, -0.35F, 0), Vec3(2, 0.5F, 2))}, 0.0F);
    CharacterState state = landed(low, 0, 1.5F, 0);
    for (int i = 0; i < 30; ++i) {
        state = apply_input(state, go(127, 0), kLimits, low, kDt);
        ASSERT_TRUE(state.grounded) << i;
    }
    EXPECT_EQ(state.position.y(), kStand);

    const StaticGeometry high({box(Vec3(0, 0, 0), Vec3(2, 1, 2))}, 0.0F);
    state = landed(high, 0, 2.5F, 0);
    bool fell = false;
    for (int i = 0; i < 30; ++i) {
        state = apply_input(state, go(127, 0), kLimits, high, kDt);
        fell = fell || !state.grounded;
    }
    EXPECT_TRUE(fell);
}

TEST(ApplyInput, ClimbsLedgesUpToItsStepAtAnySpeedAndNoHigher) {
    for (const float height : {0.05F, 0.14F, 0.2F, 0.29F}) {
        const StaticGeometry world({box(Vec3(5, 0, 0), Vec3(3, height, 3))}, 0.0F);
        for (const int speed : {10, 127}) {
            const CharacterState state =
                run(standing_at(0, 0, 0), go(speed, 0), world, 5 * 30 * 127 / (5 * speed));
            EXPECT_NEAR(state.position.y(), kStand + height, 0.0015F) << height << " " << speed;
            EXPECT_TRUE(state.grounded);
        }
    }
    for (const float height : {0.32F, 0.5F, 1.0F, 3.0F}) {
        const StaticGeometry world({box(Vec3(5, 0, 0), Vec3(3, height, 3))}, 0.0F);
        const CharacterState state = run(standing_at(0, 0, 0), go(127, 0), world, 60);
        EXPECT_EQ(state.position.y(), kStand) << height;
        EXPECT_LT(state.position.x(), 2.0F) << height;
        EXPECT_EQ(state.velocity.x(), 0.0F) << height;
    }
}

TEST(ApplyInput, ClimbsAFlightOfStairs) {
    std::vector<StaticBox> steps;
    for (int i = 0; i < 10; ++i) {
        const float top = 0.2F * static_cast<float>(i + 1);
        const float x = 2.0F + 0.3F * static_cast<float>(i);
        steps.push_back(box(Vec3(x + 5.0F, 0.5F * top, 0), Vec3(5.0F, 0.5F * top, 2.0F)));
    }
    const StaticGeometry world(steps, 0.0F);
    const CharacterState up = run(standing_at(0, 0, 0), go(127, 0), world, 60);
    EXPECT_NEAR(up.position.y(), kStand + 2.0F, 0.002F);
    CharacterState down = up;
    for (int i = 0; i < 90; ++i) {
        down = apply_input(down, go(-127, 0), kLimits, world, kDt);
        ASSERT_TRUE(down.grounded) << i;
    }
    EXPECT_EQ(down.position.y(), kStand);
}

TEST(ApplyInput, SlidesAlongAWallWithThePartOfItsSpeedThatLiesAlongIt) {
    const StaticGeometry world({box(Vec3(3, 1, 0), Vec3(0.5F, 2, 100))}, 0.0F);
    CharacterState state = run(standing_at(0, 0, 0), go(90, 90), world, 90);
    EXPECT_NEAR(state.position.x(), 2.5F - kLimits.radius, 0.0015F);
    EXPECT_EQ(state.velocity.x(), 0.0F);
    const float before = state.position.z();
    state = run(state, go(90, 90), world, 30);
    EXPECT_GT(state.position.z() - before, 3.0F);
    EXPECT_LE(penetration(state.position, world), 0.0);
}

TEST(ApplyInput, WalksOverTheSeamsOfAFloorOfSlabsWithoutAStumble) {
    std::vector<StaticBox> slabs;
    for (int i = 0; i < 40; ++i) {
        slabs.push_back(box(Vec3(static_cast<float>(i), 0.5F, 0), Vec3(0.5F, 0.5F, 5)));
    }
    const StaticGeometry world(slabs, 0.0F);
    CharacterState state = landed(world, 1.0F, 2.5F, 0.0F);
    state = run(state, go(127, 0), world, 10);
    for (int i = 0; i < 150; ++i) {
        const float before = state.position.x();
        state = apply_input(state, go(127, 0), kLimits, world, kDt);
        // Rounding only: each tick covers the full distance.
        ASSERT_NEAR(state.position.x() - before, kLimits.speed * kDt, 2e-4F) << i;
        ASSERT_NEAR(state.position.y(), 1.0F + kStand, 0.0015F) << i;
    }
}

TEST(ApplyInput, PassesACorridorThatIsHardlyWiderThanItself) {
    const float half_gap = kLimits.radius + 0.0015F;
    const StaticGeometry world({box(Vec3(10, 1, half_gap + 0.5F), Vec3(8, 2, 0.5F)),
                                box(Vec3(10, 1, -half_gap - 0.5F), Vec3(8, 2, 0.5F))},
                               0.0F);
    const CharacterState state = run(standing_at(0, 0, 0), go(127, 0), world, 150);
    EXPECT_GT(state.position.x(), 19.0F);
}

TEST(ApplyInput, DoesNotRiseThroughACeiling) {
    const StaticGeometry world({box(Vec3(0, 2.2F, 0), Vec3(5, 0.1F, 5))}, 0.0F);
    CharacterState state = standing_at(0, 0, 0);
    float top = 0.0F;
    for (int i = 0; i < 60; ++i) {
        state = apply_input(state, go(0, 0, kButtonJump), kLimits, world, kDt);
        top = std::max(top, state.position.y());
        ASSERT_LE(penetration(state.position, world), 0.0);
    }
    EXPECT_LT(top, 2.1F - kStand);
    EXPECT_GT(top, 2.1F - kStand - 0.002F);
}

TEST(ApplyInput, NeverTunnelsThroughAThinWallAtFiftyMetresPerSecond) {
    core::Rng rng(7);
    for (int i = 0; i < 500; ++i) {
        const Quat turn(Eigen::AngleAxisf(rng.range(-0.5F, 0.5F), Vec3::UnitY()) *
                        Eigen::AngleAxisf(rng.range(-0.3F, 0.3F), Vec3::UnitX()));
        const StaticGeometry world({box(Vec3(0, 3, 5), Vec3(30, 30, 0.01F), turn)}, 0.0F);
        CharacterState state = standing_at(rng.range(-2, 2), rng.range(0, 2), rng.range(-4, 0));
        state.grounded = rng.below(2) == 0;
        state.velocity = Vec3(rng.range(-10, 10), 0.0F, 50.0F);
        const Vec3 normal = turn * Vec3::UnitZ();
        for (int tick = 0; tick < 20; ++tick) {
            state = apply_input(state, go(0, 127), kLimits, world, kDt);
            ASSERT_LT(normal.dot(state.position - Vec3(0, 3, 5)), 0.0F) << i << " tick " << tick;
        }
    }
}

TEST(ApplyInput, ComesFreeWhenItBeginsInsideABox) {
    const StaticGeometry world({box(Vec3(0, 1, 0), Vec3(1, 1, 1))}, 0.0F);
    core::Rng rng(8);
    for (int i = 0; i < 200; ++i) {
        CharacterState state;
        state.position = Vec3(rng.range(-1, 1), rng.range(0.5F, 2), rng.range(-1, 1));
        state = run(state, go(0, 0), world, 60);
        EXPECT_LE(penetration(state.position, world), 0.0);
        EXPECT_TRUE(state.grounded);
    }
}

TEST(ApplyInput, IsCarriedWhereSteepSurfacesTogetherHoldIt) {
    const Quat left(Eigen::AngleAxisf(radians(60.0F), Vec3::UnitZ()));
    const Quat right(Eigen::AngleAxisf(radians(-60.0F), Vec3::UnitZ()));
    const StaticGeometry world({box(left * Vec3(0, -1, 0), Vec3(20, 1, 20), left),
                                box(right * Vec3(0, -1, 0), Vec3(20, 1, 20), right)},
                               -50.0F);
    const CharacterState state = landed(world, 0.1F, 3.0F, 0.0F);
    EXPECT_TRUE(state.grounded);
    EXPECT_TRUE(state.velocity.isZero(0.0F));
    const CharacterState up = apply_input(state, go(0, 0, kButtonJump), kLimits, world, kDt);
    EXPECT_GT(up.position.y(), state.position.y() + 0.1F);
}

/// Boxes of all sizes and tilts in a heap, some of them thin.
StaticGeometry random_world(std::uint64_t seed, int count, float extent, float offset) {
    core::Rng rng(seed);
    std::vector<StaticBox> boxes;
    for (int i = 0; i < count; ++i) {
        Quat turn(Eigen::AngleAxisf(rng.range(0, 6.28F), Vec3::UnitY()));
        if (rng.below(2) == 0) {
            turn = turn * Quat(Eigen::AngleAxisf(rng.range(-1.5F, 1.5F), Vec3::UnitX()));
        }
        boxes.push_back(box(Vec3(offset + rng.range(-extent, extent),
                                 rng.range(-0.5F, 2.5F),
                                 rng.range(-extent, extent)),
                            Vec3(rng.range(0.02F, 3), rng.range(0.02F, 1), rng.range(0.02F, 3)),
                            turn));
    }
    return StaticGeometry(boxes, 0.0F);
}

TEST(ApplyInput, NeverPenetratesByAMillimetreInHundredThousandStepsAmongRandomBoxes) {
    constexpr int kWorlds = 50;
    constexpr int kSteps = 2000;
    double worst = -1.0;
    for (int w = 0; w < kWorlds; ++w) {
        // Every other world lies a kilometre out, where a float's last bit is 0.06 mm.
        const float offset = w % 2 == 0 ? 0.0F : 1000.0F;
        const StaticGeometry world =
            random_world(100 + static_cast<std::uint64_t>(w), 120, 12.0F, offset);
        core::Rng rng(static_cast<std::uint64_t>(w));
        CharacterState state;
        InputCommand command;
        bool free_once = false;
        for (int i = 0; i < kSteps; ++i) {
            if (i % 200 == 0) {
                state = CharacterState();
                state.position = Vec3(offset + rng.range(-12, 12), 8.0F, rng.range(-12, 12));
                free_once = false;
            }
            if (rng.below(15) == 0) {
                command = go(static_cast<int>(rng.below(255)) - 127,
                             static_cast<int>(rng.below(255)) - 127,
                             static_cast<std::uint16_t>(rng.below(4)));
            }
            state = apply_input(state, command, kLimits, world, kDt);
            const double depth = penetration(state.position, world);
            free_once = free_once || depth <= 0.0;
            ASSERT_TRUE(state.position.allFinite());
            if (free_once) {
                ASSERT_LT(depth, 0.001) << "world " << w << " step " << i;
                worst = std::max(worst, depth);
            }
        }
    }
    RecordProperty("worst_penetration_um", static_cast<int>(worst * 1e6));
}

TEST(ApplyInput, NeverPassesThroughAWallHoweverItIsPushed) {
    // A closed ring of thin walls that lean in and out: a character inside stays inside.
    std::vector<StaticBox> ring;
    for (int i = 0; i < 8; ++i) {
        const float angle = radians(45.0F * static_cast<float>(i));
        const Quat turn = Quat(Eigen::AngleAxisf(angle, Vec3::UnitY())) *
                          Quat(Eigen::AngleAxisf(i % 2 == 0 ? 0.3F : -0.3F, Vec3::UnitX()));
        ring.push_back(box(Quat(Eigen::AngleAxisf(angle, Vec3::UnitY())) * Vec3(0, 0, 5),
                           Vec3(4, 12, 0.01F),
                           turn));
    }
    const StaticGeometry world(ring, 0.0F);
    core::Rng rng(9);
    CharacterState state = standing_at(0, 0, 0);
    InputCommand command;
    for (int i = 0; i < 20000; ++i) {
        if (rng.below(20) == 0) {
            command = go(static_cast<int>(rng.below(255)) - 127,
                         static_cast<int>(rng.below(255)) - 127,
                         static_cast<std::uint16_t>(rng.below(4)));
        }
        if (rng.below(50) == 0) {
            state.velocity += Vec3(rng.range(-50, 50), 0.0F, rng.range(-50, 50));
            state.grounded = state.grounded && rng.below(2) == 0;
        }
        state = apply_input(state, command, kLimits, world, kDt);
        ASSERT_LT(std::hypot(state.position.x(), state.position.z()), 9.0F) << i;
    }
}

TEST(ApplyInput, GivesTheSameBitsForTheSameArguments) {
    const StaticGeometry a = random_world(3, 200, 15.0F, 0.0F);
    const StaticGeometry b = random_world(3, 200, 15.0F, 0.0F);
    core::Rng rng(10);
    CharacterState first;
    first.position = Vec3(0.0F, 8.0F, 0.0F);
    CharacterState second = first;
    for (int i = 0; i < 3000; ++i) {
        const InputCommand command = go(static_cast<int>(rng.below(255)) - 127,
                                        static_cast<int>(rng.below(255)) - 127,
                                        static_cast<std::uint16_t>(rng.below(4)));
        first = apply_input(first, command, kLimits, a, kDt);
        second = apply_input(second, command, kLimits, b, kDt);
        ASSERT_TRUE(same_bits(first.position, second.position));
        ASSERT_TRUE(same_bits(first.velocity, second.velocity));
        ASSERT_EQ(first.grounded, second.grounded);
    }
}

TEST(ApplyInput, AStandingCharacterTurnsWithItsCommand) {
    InputCommand command;
    command.yaw = 12345;
    const CharacterState state =
        apply_input(standing_at(1, 0, 1), command, kLimits, flat_world(), kDt);
    EXPECT_EQ(state.yaw, 12345);
    EXPECT_TRUE(same_bits(state.position, standing_at(1, 0, 1).position));
}

TEST(OrientationFromYaw, TurnsAboutUpFromPlusZTowardsPlusX) {
    EXPECT_LT((orientation_from_yaw(0) * Vec3::UnitZ() - Vec3::UnitZ()).norm(), 1e-6F);
    EXPECT_LT((orientation_from_yaw(16384) * Vec3::UnitZ() - Vec3::UnitX()).norm(), 1e-6F);
    EXPECT_LT((orientation_from_yaw(32768) * Vec3::UnitZ() + Vec3::UnitZ()).norm(), 1e-6F);
    EXPECT_LT((orientation_from_yaw(49152) * Vec3::UnitZ() + Vec3::UnitX()).norm(), 1e-6F);
    for (int yaw = 0; yaw < 65536; yaw += 97) {
        const Quat q = orientation_from_yaw(static_cast<std::uint16_t>(yaw));
        EXPECT_NEAR(q.norm(), 1.0F, 1e-6F);
        EXPECT_GE(q.w(), 0.0F);
    }
}

}  // namespace
}  // namespace zoned::motion
