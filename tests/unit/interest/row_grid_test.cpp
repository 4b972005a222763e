#include "server/interest/row_grid.h"

#include "server/interest/interest_rule.h"
#include "shared/core/rng.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

namespace zoned::interest {
namespace {

struct Cloud {
    std::vector<float> x, z, radius_m;

    void add(float at_x, float at_z, float radius) {
        x.push_back(at_x);
        z.push_back(at_z);
        radius_m.push_back(radius);
    }

    [[nodiscard]] RowGridPoints points() const { return {x, z, radius_m}; }
};

/// The rule itself, for all points; ascending.
std::vector<std::uint32_t> all_near(const Cloud& cloud, const RowGridQuery& query) {
    std::vector<std::uint32_t> near;
    for (std::uint32_t key = 0; key < cloud.x.size(); ++key) {
        const float dx = cloud.x[key] - query.x;
        const float dz = cloud.z[key] - query.z;
        if (key != query.own &&
            hears(dx * dx + dz * dz, query.radius_m, cloud.radius_m[key], false, 0.0F)) {
            near.push_back(key);
        }
    }
    return near;
}

/// Compares all queries with the rule, each with its keys in its own place. Returns how many pairs
/// there are.
std::size_t compare(RowGrid& strips, const Cloud& cloud, const std::vector<RowGridQuery>& queries) {
    constexpr std::uint32_t kFrom = 3;
    std::vector<std::uint32_t> keys(kFrom, 77);
    std::vector<std::uint32_t> ends(queries.size());
    strips.match(queries, kFrom, keys, ends);
    std::uint32_t begin = kFrom;
    for (std::size_t i = 0; i < queries.size(); ++i) {
        EXPECT_LE(begin, ends[i]);
        std::vector<std::uint32_t> found(keys.begin() + begin, keys.begin() + ends[i]);
        std::sort(found.begin(), found.end());
        EXPECT_EQ(found, all_near(cloud, queries[i])) << "query " << i;
        begin = ends[i];
    }
    EXPECT_EQ(std::vector<std::uint32_t>(keys.begin(), keys.begin() + kFrom),
              std::vector<std::uint32_t>(kFrom, 77));
    return begin - kFrom;
}

/// Layouts that a plan by a sample of the points may not expect.
Cloud cloud_of(const std::string& layout, core::Rng& rng, std::size_t size, bool alike) {
    Cloud cloud;
    for (std::size_t i = 0; i < size; ++i) {
        float x = rng.range(-200, 200);
        float z = rng.range(-200, 200);
        if (layout == "clusters") {
            x = 100.0F * static_cast<float>(rng.below(3)) + rng.range(-2, 2);
            z = 100.0F * static_cast<float>(rng.below(3)) + rng.range(-2, 2);
        } else if (layout == "one place") {
            x = 12.5F;
            z = -7.25F;
        } else if (layout == "along x") {
            z = 3.0F;
        } else if (layout == "along z") {
            x = 3.0F;
        } else if (layout == "far away") {
            x += 3.0e5F;
            z -= 7.0e5F;
        } else if (layout == "one elsewhere" && i + 1 == size) {
            x = -4.0e6F;
            z = 9.0e7F;
        } else if (layout == "narrow") {
            x = rng.range(0, 1);
        } else if (layout == "lattice") {
            x = static_cast<float>(rng.below(40));
            z = static_cast<float>(rng.below(40));
        }
        cloud.add(x, z, alike ? 60.0F : static_cast<float>(rng.below(4)) * 20.0F);
    }
    return cloud;
}

std::vector<RowGridQuery> queries_in(const Cloud& cloud, core::Rng& rng, float radius) {
    std::vector<RowGridQuery> queries;
    for (std::uint32_t key = 0; key < cloud.x.size(); key += 7) {
        queries.push_back({cloud.x[key], cloud.z[key], radius, key});
    }
    // Also from where no point is, within the extent and far beyond it.
    for (int i = 0; i < 20; ++i) {
        const float far = i % 2 == 0 ? 1.0F : 1000.0F;
        queries.push_back({cloud.x[0] + far * rng.range(-300, 300),
                           cloud.z[0] + far * rng.range(-300, 300),
                           radius * rng.range(0.1F, 4.0F),
                           0xFFFFFFFFU});
    }
    return queries;
}

TEST(RowGrid, GiveWhatAllPointsGive) {
    core::Rng rng(11);
    RowGrid strips;  // one for all: nothing of an earlier cloud may stay
    for (const bool alike : {true, false}) {
        for (const std::string layout : {"even",
                                         "clusters",
                                         "one place",
                                         "along x",
                                         "along z",
                                         "far away",
                                         "one elsewhere",
                                         "narrow",
                                         "lattice"}) {
            for (const std::size_t size : {1U, 2U, 50U, 3000U}) {
                for (const float radius : {0.5F, 5.0F, 60.0F, 1000.0F}) {
                    SCOPED_TRACE(layout + ", " + std::to_string(size) + " points, radius " +
                                 std::to_string(radius));
                    const Cloud cloud = cloud_of(layout, rng, size, alike);
                    strips.build(cloud.points(), radius);
                    const std::size_t pairs =
                        compare(strips, cloud, queries_in(cloud, rng, radius));
                    if (size == 3000 && radius >= 5.0F) {
                        EXPECT_GT(pairs, 100U);
                    }
                    if (::testing::Test::HasFailure()) {
                        return;
                    }
                }
            }
        }
    }
}

TEST(RowGrid, NoPointsAreNearNobody) {
    RowGrid strips;
    Cloud cloud;
    strips.build(cloud.points(), 10.0F);
    EXPECT_EQ(compare(strips, cloud, {{0, 0, 10, 0}, {1e6F, -1e6F, 1e6F, 1}}), 0U);
    cloud.add(std::numeric_limits<float>::quiet_NaN(), 0.0F, 0.0F);
    cloud.add(0.0F, std::numeric_limits<float>::infinity(), 0.0F);
    cloud.add(0.0F, 0.0F, 0.0F);
    strips.build(cloud.points(), 10.0F);
    EXPECT_EQ(compare(strips, cloud, {{0, 0, 10, 0xFFFFFFFFU}}), 0U);
}

/// 3-4-5: the squares are exact in floats.
TEST(RowGrid, ExactlyAtTheRadiusIsWithinAndTheNextFloatIsNot) {
    RowGrid strips;
    for (const float shift : {0.0F, 1024.0F, -65536.0F}) {
        Cloud cloud;
        cloud.add(shift, shift, 5.0F);
        for (const float side : {-1.0F, 1.0F}) {
            cloud.add(shift + 3.0F * side, shift + 4.0F * side, 5.0F);
            cloud.add(shift + 5.0F * side, shift, 5.0F);
            cloud.add(shift, shift - 5.0F * side, 5.0F);
            cloud.add(std::nextafter(shift + 5.0F * side, side * 1e9F), shift, 5.0F);
            cloud.add(shift, std::nextafter(shift + 5.0F * side, side * 1e9F), 5.0F);
        }
        strips.build(cloud.points(), 5.0F);
        EXPECT_EQ(compare(strips, cloud, {{shift, shift, 5.0F, 0}}), 6U);
    }
}

TEST(RowGrid, AreUsedAgainWithoutAnythingOfBefore) {
    core::Rng rng(3);
    RowGrid strips;
    const Cloud many = cloud_of("even", rng, 5000, true);
    strips.build(many.points(), 30.0F);
    EXPECT_GT(compare(strips, many, queries_in(many, rng, 30.0F)), 1000U);
    const Cloud few = cloud_of("clusters", rng, 9, true);
    strips.build(few.points(), 30.0F);
    compare(strips, few, queries_in(few, rng, 30.0F));
}

}  // namespace
}  // namespace zoned::interest
