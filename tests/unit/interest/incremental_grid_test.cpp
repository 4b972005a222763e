#include "server/interest/incremental_grid.h"

#include "server/interest/interest_rule.h"
#include "server/interest/pair_matcher.h"
#include "shared/core/rng.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>

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
            // 0.1 is what turns into 1.1 here.
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

TEST(PairMatcher, FindsThePairsThatAllPairsFind) {
    world::TypeTable types(2);
    types[0].aura_m.fill(30.0F);
    types[0].nimbus_m.fill(45.0F);
    types[1].aura_m = {60, 0, 20, 60};
    core::Rng rng(8);
    PairMatcher matcher;
    Pairs found;
    for (int round = 0; round < 20; ++round) {
        world::Entities e;
        std::vector<world::Viewer> viewers;
        for (std::uint32_t id = 1; id <= 300; ++id) {
            const world::Row row = e.add(EntityId(id), static_cast<TypeIndex>(rng.below(2)));
            e.position[row] = Vec3(rng.range(-80, 80), 0, rng.range(-80, 80));
            e.stance[row] = static_cast<std::uint8_t>(rng.below(4));
            e.set(row, world::kHidden, rng.below(10) == 0);
            if (id % 9 == 0) {
                viewers.push_back({ClientId(id), EntityId(id + (id % 2) * 1000)});
            }
        }
        e.position[7].x() = std::numeric_limits<float>::infinity();
        matcher.step(e, types, viewers, found);
        std::size_t pairs = 0;
        for (std::size_t i = 0; i < viewers.size(); ++i) {
            std::vector<world::Row> inner, outer;
            brute_force(e, types, viewers[i], InterestSettings{}, inner, outer);
            std::vector<world::Row> rows(found.rows.begin() + found.first[i],
                                         found.rows.begin() + found.first[i] + found.count[i]);
            std::sort(rows.begin(), rows.end());
            ASSERT_EQ(rows, inner) << "viewer " << i;
            pairs += inner.size();
        }
        EXPECT_EQ(found.size, pairs);
        EXPECT_GT(pairs, 50U);
    }
}

}  // namespace
}  // namespace zoned::interest
