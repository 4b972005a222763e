// Large batches of rays are cast in another order and answered in the caller's.
#include "server/physics/query/ray_order.h"

#include "server/physics/scene/scene.h"
#include "tests/unit/allocation_count.h"
#include "shared/core/rng.h"

#include <gtest/gtest.h>

#include <limits>
#include <vector>

namespace zoned::physics {
namespace {

Vec3 point_within(core::Rng& rng, float side) {
    const float x = rng.range(-side, side);
    const float y = rng.range(-side, side);
    const float z = rng.range(-side, side);
    return {x, y, z};
}

std::vector<Ray> some_rays(std::size_t count, float side) {
    core::Rng rng(5);
    std::vector<Ray> rays;
    for (std::size_t i = 0; i < count; ++i) {
        rays.push_back({point_within(rng, side), point_within(rng, 1.0F), 40.0F});
    }
    return rays;
}

TEST(RayOrder, NamesEachRayOnceAndPutsItsHitBack) {
    const std::vector<Ray> rays = some_rays(1000, 50.0F);
    std::vector<QueryHit> hits(rays.size());
    order_rays(rays, hits);
    std::vector<int> named(rays.size(), 0);
    std::size_t moved = 0;
    for (std::size_t k = 0; k < hits.size(); ++k) {
        ASSERT_LT(hits[k].user, rays.size());
        ++named[hits[k].user];
        moved += hits[k].user != k ? 1 : 0;
        hits[k].distance = static_cast<float>(hits[k].user);
    }
    EXPECT_EQ(named, std::vector<int>(rays.size(), 1));
    EXPECT_GT(moved, rays.size() / 2);
    put_in_place(hits);
    for (std::size_t i = 0; i < hits.size(); ++i) {
        EXPECT_EQ(hits[i].distance, static_cast<float>(i));
    }
}

// Random points of a cube of side s are 0.66 s apart in the mean. A thousand in Morton order lie in
// cells of a tenth of that and leap now and then: less than a third of it.
TEST(RayOrder, BringsNeighboursTogether) {
    const std::vector<Ray> rays = some_rays(1000, 50.0F);
    std::vector<QueryHit> hits(rays.size());
    order_rays(rays, hits);
    double given = 0.0;
    double ordered = 0.0;
    for (std::size_t k = 1; k < rays.size(); ++k) {
        given += static_cast<double>((rays[k].origin - rays[k - 1].origin).norm());
        ordered +=
            static_cast<double>((rays[hits[k].user].origin - rays[hits[k - 1].user].origin).norm());
    }
    EXPECT_LT(ordered, given / 3.0);
}

TEST(RayOrder, IsOnlyForManyRaysAmongMoreBodiesThanCachesHold) {
    EXPECT_TRUE(worth_ordering(100'000, 300'000));
    EXPECT_TRUE(worth_ordering(10'000, 300'000));
    EXPECT_FALSE(worth_ordering(1000, 300'000));
    EXPECT_FALSE(worth_ordering(100'000, 20'000));
    EXPECT_FALSE(worth_ordering(0, 0));
}

TEST(RayOrder, ChangesNoAnswerAndAllocatesNothing) {
    constexpr float kSide = 80.0F;
    Scene scene{PhysicsSettings()};
    core::Rng rng(6);
    constexpr std::size_t kBodies = (1U << 16) + 100;
    for (std::size_t i = 0; i < kBodies; ++i) {
        BodyDef def;
        def.kind = BodyKind::kStatic;
        def.shape = Shape::sphere(rng.range(0.2F, 0.8F));
        def.position = point_within(rng, kSide);
        def.user = static_cast<std::uint32_t>(i % 7);
        ASSERT_TRUE(scene.add(def).ok());
    }
    std::vector<Ray> rays = some_rays(3000, kSide);
    rays[3].origin.x() = std::numeric_limits<float>::quiet_NaN();
    rays[4].origin.y() = std::numeric_limits<float>::infinity();
    rays[5].direction.setZero();
    rays[6].origin.z() = 1.0e5F;
    ASSERT_TRUE(worth_ordering(rays.size(), scene.body_count()));
    QueryFilter filter;
    filter.ignore_user = 3;
    std::vector<QueryHit> hits(rays.size());
    const Query query = scene.query();
    const std::size_t before = allocation_count();
    query.rays(rays, filter, hits);
    EXPECT_EQ(allocation_count(), before);
    std::size_t found = 0;
    for (std::size_t i = 0; i < rays.size(); ++i) {
        QueryHit hit;
        if (!query.ray(rays[i], filter, hit)) {
            hit = QueryHit();
        }
        found += hit.body ? 1 : 0;
        EXPECT_EQ(hits[i].body, hit.body) << i;
        EXPECT_EQ(hits[i].user, hit.user) << i;
        EXPECT_EQ(hits[i].distance, hit.distance) << i;
        EXPECT_EQ(hits[i].point, hit.point) << i;
        EXPECT_EQ(hits[i].normal, hit.normal) << i;
    }
    EXPECT_GT(found, rays.size() / 4);
    EXPECT_LT(found, rays.size());
}

}  // namespace
}  // namespace zoned::physics
