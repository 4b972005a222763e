#include "server/interest/incremental_grid.h"

#include "server/interest/interest_rule.h"
#include "shared/core/rng.h"

#include <gtest/gtest.h>

#include <algorithm>

namespace zoned::interest {
namespace {

/// Points that come, go and move, and a grid that follows them.
struct Followed {
    std::vector<float> x, z, radius;
    IncrementalGrid grid;

    explicit Followed(std::size_t keys) : x(keys), z(keys), radius(keys) {}

    void build(float cell_m) { grid.build({x, z, radius}, cell_m); }

    std::vector<std::uint32_t> near(float at_x, float at_z, float r, std::uint32_t own) const {
        std::vector<std::uint32_t> found(grid.keys() + spatial::kLanes);
        found.resize(grid.gather(at_x, at_z, r, 1.1F, own, found.data()));
        std::sort(found.begin(), found.end());
        return found;
    }

    std::vector<std::uint32_t> all_near(float at_x, float at_z, float r, std::uint32_t own) const {
        std::vector<std::uint32_t> found;
        for (std::uint32_t key = 0; key < x.size(); ++key) {
            const float dx = x[key] - at_x;
            const float dz = z[key] - at_z;
            // The hysteresis of 0.1 gives the factor 1.1 here.
            if (key != own && hears(dx * dx + dz * dz, r, radius[key], true, 0.1F)) {
                found.push_back(key);
            }
        }
        return found;
    }
};

TEST(IncrementalGrid, FindsWhatAllPairsFindWhilePointsComeGoAndMove) {
    constexpr std::uint32_t kKeys = 400;
    core::Rng rng(3);
    Followed f(kKeys);
    for (std::uint32_t key = 0; key < kKeys; ++key) {
        f.x[key] = rng.range(-100, 100);
        f.z[key] = rng.range(-80, 80);
        f.radius[key] = rng.below(4) == 0 ? 0.0F : rng.range(5, 40);
    }
    f.build(11.0F);
    int rebuilt = 0;
    for (int round = 0; round < 4000; ++round) {
        const std::uint32_t key = rng.below(kKeys);
        bool good = true;
        if (!f.grid.holds(key)) {
            f.x[key] = rng.range(-130, 130);
            f.z[key] = rng.range(-130, 130);
            f.radius[key] = rng.range(5, 40);
            good = f.grid.put(key, f.x[key], f.z[key], f.radius[key]);
        } else if (rng.below(8) == 0) {
            f.grid.take(key);
            f.radius[key] = 0.0F;
        } else {
            // Half of them crowd into one corner: cells there fill up and borrow.
            f.x[key] = rng.below(2) == 0 ? rng.range(-100, -90) : rng.range(-130, 130);
            f.z[key] = rng.range(-80, -70);
            good = f.grid.move(key, f.x[key], f.z[key]);
        }
        if (!good) {
            f.build(11.0F);
            ++rebuilt;
        }
        if (round % 5 == 0) {
            const float x = rng.range(-130, 130);
            const float z = rng.range(-130, 130);
            const float r = rng.range(1, 60);
            ASSERT_EQ(f.near(x, z, r, key), f.all_near(x, z, r, key)) << "round " << round;
        }
    }
    EXPECT_LT(rebuilt, 200);
}

}  // namespace
}  // namespace zoned::interest
