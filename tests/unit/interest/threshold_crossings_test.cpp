#include "server/interest/threshold_crossings.h"

#include "shared/core/rng.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>

namespace zoned::interest {
namespace {

constexpr float kWiden = 1.1F;

/// The number of pairs that crossed a threshold and that a test of present places alone missed,
/// named, and the number of all such pairs.
struct Count {
    int crossed = 0;
    int missed = 0;
    int named = 0;
    int all = 0;
};

/// Eight points at a time step by up to `step_m` about a point that steps as far. NearThresholds is
/// given `told` as the bound of both steps together.
Count count_near(float step_m, float told, bool flat) {
    InterestSettings settings;
    settings.lod_radius_m = {20.0F, 30.0F};
    const LodThresholds lods(settings);
    core::Rng rng(17);
    Count count;
    const auto along = [&] {
        return rng.range(-step_m, step_m) * std::sqrt(0.5F);
    };
    for (int round = 0; round < 20000; ++round) {
        const float old_x = rng.range(-4000, 4000);
        const float old_z = rng.range(-4000, 4000);
        const float x = old_x + along();
        const float z = old_z + along();
        const float nimbus = 50.0F;
        Array8 xs, zs, radii, before;
        for (int i = 0; i < 8; ++i) {
            const float at_x = old_x + rng.range(-60, 60);
            const float at_z = old_z + rng.range(-60, 60);
            xs[i] = at_x + along();
            zs[i] = at_z + along();
            radii[i] = flat ? 50.0F : rng.range(10, 70);
            before[i] = (at_x - old_x) * (at_x - old_x) + (at_z - old_z) * (at_z - old_z);
        }
        const float reach = told * 2.0F * step_m * 1.0001F + 2e-3F;  // places are rounded by 2^-13
        const NearThresholds near(x, z, nimbus, kWiden, reach, lods);
        const std::uint32_t mask = flat ? near.flat(xs, zs) : near(xs, zs, radii);
        for (int i = 0; i < 8; ++i) {
            const float now = (xs[i] - x) * (xs[i] - x) + (zs[i] - z) * (zs[i] - z);
            const bool named = (mask >> i & 1U) != 0;
            const bool did = crossed(now, before[i], std::min(nimbus, radii[i]), kWiden, lods);
            count.crossed += did ? 1 : 0;
            count.missed += did && !named ? 1 : 0;
            count.named += named ? 1 : 0;
            ++count.all;
        }
    }
    return count;
}

TEST(NearThresholds, MissNoPairThatCameAcrossAStep) {
    for (const bool flat : {true, false}) {
        for (const float step_m : {0.05F, 0.5F, 8.0F}) {
            const Count count = count_near(step_m, 1.0F, flat);
            EXPECT_EQ(count.missed, 0) << "flat " << flat << ", step " << step_m;
            EXPECT_GT(count.crossed, 100) << "flat " << flat << ", step " << step_m;
        }
    }
}

TEST(NearThresholds, MissSomeWhenToldOfAFractionOfTheStep) {
    EXPECT_GT(count_near(0.5F, 0.2F, true).missed, 0);
    EXPECT_GT(count_near(0.5F, 0.2F, false).missed, 0);
}

TEST(MutualCrossings, SayOfEightWhatCrossedSaysOfEach) {
    InterestSettings settings;
    settings.lod_radius_m = {20.0F, 30.0F};
    const LodThresholds lods(settings);
    core::Rng rng(23);
    int did = 0;
    int all = 0;
    for (int round = 0; round < 20000; ++round) {
        const bool flat = round % 2 == 0;
        Array8 xs, zs, old_xs, old_zs, radii;
        MutualCrossings test;
        test.radius_m = 50.0F;
        test.widen = kWiden;
        test.lods = &lods;
        test.old_x = rng.range(-4000, 4000);
        test.old_z = rng.range(-4000, 4000);
        test.x = test.old_x + rng.range(-3, 3);
        test.z = test.old_z + rng.range(-3, 3);
        for (int i = 0; i < 8; ++i) {
            old_xs[i] = test.old_x + rng.range(-60, 60);
            old_zs[i] = test.old_z + rng.range(-60, 60);
            xs[i] = old_xs[i] + rng.range(-3, 3);
            zs[i] = old_zs[i] + rng.range(-3, 3);
            radii[i] = flat ? 50.0F : rng.range(10, 70);
        }
        test.old_xs = old_xs.data();
        test.old_zs = old_zs.data();
        const std::uint32_t mask = flat ? test.flat(xs, zs) : test(xs, zs, radii);
        for (int i = 0; i < 8; ++i) {
            const float dx = xs[i] - test.x;
            const float dz = zs[i] - test.z;
            const float old_dx = old_xs[i] - test.old_x;
            const float old_dz = old_zs[i] - test.old_z;
            const bool one = crossed(dx * dx + dz * dz,
                                     old_dx * old_dx + old_dz * old_dz,
                                     std::min(test.radius_m, radii[i]),
                                     kWiden,
                                     lods);
            ASSERT_EQ((mask >> i & 1U) != 0, one) << "round " << round << ", lane " << i;
            did += one ? 1 : 0;
            ++all;
        }
    }
    EXPECT_GT(did, 1000);
    EXPECT_LT(did, all / 2);
}

TEST(NearThresholds, NameFewWhereStepsAreSmall) {
    // Six rings, 0.1 m to both sides and the 2 mm of the test, of 23 to 55 m (229 m in all) in a
    // square of 120 m: 2 pi 229 x 0.204 / 14,400 = 2.0 %.
    const Count count = count_near(0.05F, 1.0F, true);
    EXPECT_LT(count.named, 0.03 * count.all);
}

}  // namespace
}  // namespace zoned::interest
