// Rays and sets of answers: the promises of a Query beyond single shapes.
#include "server/physics/query/query.h"

#include "server/physics/scene/scene.h"
#include "tests/unit/allocation_count.h"
#include "tests/unit/physics/physics_test.h"
#include "shared/core/rng.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <vector>

namespace zoned::physics {
namespace {

const Shape kBall = Shape::sphere(0.5F);

BodyDef still_ball(const Vec3& x, std::uint32_t user = 0) {
    BodyDef def;
    def.shape = kBall;
    def.position = x;
    def.user = user;
    return def;
}

/// Balls of radius 0.5 in a row along x, 2 m apart, the first at x = 2, in the order of ids.
struct Row {
    Scene scene{PhysicsSettings()};
    std::vector<BodyId> balls;

    explicit Row(int n) {
        for (int i = 0; i < n; ++i) {
            BodyDef def = still_ball(Vec3(2.0F * static_cast<float>(i + 1), 0, 0),
                                     static_cast<std::uint32_t>(i + 1));
            def.kind = i % 3 == 0   ? BodyKind::kDynamic
                       : i % 3 == 1 ? BodyKind::kStatic
                                    : BodyKind::kKinematic;
            def.filter.category = i % 2 == 0 ? 1U : 2U;
            balls.push_back(*scene.add(def));
        }
    }
};

TEST(Query, ListsAllHitsFromNearToFarAndSaysWhenThereAreMore) {
    const Row row(6);
    const Query query = row.scene.query();
    const Ray ray{Vec3::Zero(), Vec3(3, 0, 0), 100.0F};
    std::array<QueryHit, 8> hits;
    QueryCount count = query.ray_all(ray, kAll, hits);
    EXPECT_EQ(count.written, 6U);
    EXPECT_FALSE(count.more);
    for (std::size_t i = 0; i < 6; ++i) {
        EXPECT_EQ(hits[i].body, row.balls[i]);
        EXPECT_EQ(hits[i].user, i + 1);
        EXPECT_NEAR(hits[i].distance, 2.0F * static_cast<float>(i) + 1.5F, 1e-5F);
        EXPECT_NEAR(hits[i].normal.x(), -1.0F, 1e-6F);
        EXPECT_NEAR(hits[i].point.x(), hits[i].distance, 1e-5F);
    }
    for (const std::size_t room : {0U, 1U, 3U, 5U}) {
        count = query.ray_all(ray, kAll, std::span(hits).first(room));
        EXPECT_EQ(count.written, room);
        EXPECT_TRUE(count.more);
        for (std::size_t i = 0; i < room; ++i) {
            EXPECT_EQ(hits[i].body, row.balls[i]);
        }
    }
    count = query.cast_all({{kBall}, Vec3::UnitX(), 6.9F}, kAll, hits);
    EXPECT_EQ(count.written, 3U);  // touched after 1, 3 and 5 m
    EXPECT_FALSE(count.more);
    EXPECT_NEAR(hits[2].distance, 5.0F, 1e-5F);
    EXPECT_TRUE(query.ray_any(ray, kAll));
    EXPECT_TRUE(query.cast_any({{kBall}, Vec3::UnitX(), 6.9F}, kAll));
    EXPECT_FALSE(query.ray_any({Vec3::Zero(), -Vec3::UnitX(), 100.0F}, kAll));
    EXPECT_FALSE(query.cast_any({{kBall}, Vec3::UnitX(), 0.9F}, kAll));
}

TEST(Query, LeavesOutWhatTheFilterLeavesOut) {
    const Row row(6);
    const Query query = row.scene.query();
    const Ray ray{Vec3::Zero(), Vec3::UnitX(), 100.0F};
    std::array<QueryHit, 8> hits;
    const auto seen = [&](const QueryFilter& filter) {
        const std::size_t n = query.ray_all(ray, filter, hits).written;
        std::vector<std::uint32_t> users;
        for (std::size_t i = 0; i < n; ++i) {
            users.push_back(hits[i].user);
        }
        std::array<BodyId, 8> bodies;
        const Shape box = Shape::box(Vec3(20, 1, 1));
        EXPECT_EQ(query.overlap({box}, filter, bodies).written, n);
        QueryHit nearest;
        EXPECT_EQ(query.closest_to_point(Vec3::Zero(), 100.0F, filter, nearest), n > 0);
        EXPECT_EQ(nearest.user, n > 0 ? users[0] : 0U);
        return users;
    };
    using Users = std::vector<std::uint32_t>;
    EXPECT_EQ(seen(kAll), (Users{1, 2, 3, 4, 5, 6}));
    QueryFilter filter;
    filter.ignore_user = 2;
    EXPECT_EQ(seen(filter), (Users{1, 3, 4, 5, 6}));
    filter.categories = 1;
    EXPECT_EQ(seen(filter), (Users{1, 3, 5}));
    filter.dynamics = false;
    EXPECT_EQ(seen(filter), (Users{3, 5}));
    filter.statics = false;
    EXPECT_EQ(seen(filter), (Users{3}));
    filter.kinematics = false;
    EXPECT_EQ(seen(filter), (Users{}));
}

TEST(Query, SeesSensorsOnlyWhenAskedTo) {
    Scene scene{PhysicsSettings()};
    BodyDef def = still_ball(Vec3(3, 0, 0));
    def.sensor = true;
    ASSERT_TRUE(scene.add(def).ok());
    QueryHit hit;
    const Ray ray{Vec3::Zero(), Vec3::UnitX(), 10.0F};
    EXPECT_FALSE(scene.query().ray(ray, kAll, hit));
    QueryFilter filter;
    filter.sensors = true;
    EXPECT_TRUE(scene.query().ray(ray, filter, hit));
    EXPECT_NEAR(hit.distance, 2.5F, 1e-6F);
}

TEST(Query, OfEqualDistancesTheLowerIdComesFirst) {
    for (const BroadphaseKind kind : {BroadphaseKind::kTree, BroadphaseKind::kGrid}) {
        PhysicsSettings settings;
        settings.broadphase = kind;
        Scene scene(settings);
        std::vector<BodyId> ids;
        for (int i = 0; i < 40; ++i) {
            BodyDef def = still_ball(Vec3(5, 0, 0));
            def.kind = i % 2 == 0 ? BodyKind::kDynamic : BodyKind::kStatic;
            ids.push_back(*scene.add(def));
        }
        QueryHit hit;
        ASSERT_TRUE(scene.query().ray({Vec3::Zero(), Vec3::UnitX(), 10.0F}, kAll, hit));
        EXPECT_EQ(hit.body, ids[0]);
        ASSERT_TRUE(scene.query().cast({{kBall}, Vec3::UnitX(), 10.0F}, kAll, hit));
        EXPECT_EQ(hit.body, ids[0]);
        ASSERT_TRUE(scene.query().closest_to_point(Vec3::Zero(), 10.0F, kAll, hit));
        EXPECT_EQ(hit.body, ids[0]);
        std::array<BodyId, 5> bodies;
        const QueryCount count = scene.query().overlap({kBall, Vec3(5, 0.3F, 0)}, kAll, bodies);
        EXPECT_EQ(count.written, 5U);
        EXPECT_TRUE(count.more);
        EXPECT_TRUE(std::equal(bodies.begin(), bodies.end(), ids.begin()));
    }
}

TEST(Query, AnswersBatchesAsItAnswersOneByOne) {
    const Row row(6);
    const Query query = row.scene.query();
    core::Rng rng(2);
    std::vector<Ray> rays;
    std::vector<ShapeCast> casts;
    for (int i = 0; i < 100; ++i) {
        const Vec3 from(rng.range(-2, 16), rng.range(-3, 3), rng.range(-3, 3));
        const Vec3 to(rng.range(0, 14), rng.range(-1, 1), rng.range(-1, 1));
        rays.push_back({from, to - from, 20.0F});
        casts.push_back({{kBall, from}, to - from, 20.0F});
    }
    std::vector<QueryHit> by_ray(100);
    std::vector<QueryHit> by_cast(100);
    query.rays(rays, kAll, by_ray);
    query.casts(casts, kAll, by_cast);
    int hits = 0;
    for (std::size_t i = 0; i < 100; ++i) {
        QueryHit hit;
        query.ray(rays[i], kAll, hit);
        EXPECT_EQ(hit.body, by_ray[i].body);
        EXPECT_EQ(hit.distance, by_ray[i].distance);
        hits += hit.body ? 1 : 0;
        hit = QueryHit();
        query.cast(casts[i], kAll, hit);
        EXPECT_EQ(hit.body, by_cast[i].body);
        EXPECT_EQ(hit.distance, by_cast[i].distance);
    }
    EXPECT_GT(hits, 20);
    EXPECT_LT(hits, 90);
}

TEST(Query, HitsNothingWhenAskedNonsense) {
    Row row(3);
    BodyDef floor;
    floor.kind = BodyKind::kStatic;
    floor.shape = Shape::plane();
    floor.position = Vec3(0, -3, 0);
    ASSERT_TRUE(row.scene.add(floor).ok());
    const Query query = row.scene.query();
    QueryHit hit;
    for (const Vec3& bad : {Vec3(kNan, 0, 0), Vec3(INFINITY, 0, 0), Vec3(0, 3e30F, 0)}) {
        EXPECT_FALSE(query.ray({bad, Vec3::UnitX(), 10}, kAll, hit));
        EXPECT_FALSE(query.cast({{kBall, bad}, Vec3::UnitX(), 10}, kAll, hit));
        EXPECT_FALSE(query.closest_to_point(bad, 10, kAll, hit));
        EXPECT_FALSE(query.overlap_any({kBall, bad}, kAll));
    }
    for (const Vec3& bad : {Vec3(kNan, 0, 0), Vec3(INFINITY, 0, 0), Vec3(0, 0, 0)}) {
        EXPECT_FALSE(query.ray({Vec3::Zero(), bad, 10}, kAll, hit));
        EXPECT_FALSE(query.cast({{kBall}, bad, 10}, kAll, hit));
    }
    for (const float bad : {kNan, -1.0F, -INFINITY}) {
        EXPECT_FALSE(query.ray({Vec3::Zero(), Vec3::UnitX(), bad}, kAll, hit));
        EXPECT_FALSE(query.cast({{kBall}, Vec3::UnitX(), bad}, kAll, hit));
        EXPECT_FALSE(query.closest_to_point(Vec3::Zero(), bad, kAll, hit));
    }
    const Vec3 in_a_ball(2, 0, 0);
    for (const Shape& bad : {Shape::sphere(-1), Shape::sphere(kNan), Shape::plane()}) {
        EXPECT_FALSE(query.cast({{bad, in_a_ball}, Vec3::UnitX(), 10}, kAll, hit));
        EXPECT_FALSE(query.overlap_any({bad, in_a_ball}, kAll));
        EXPECT_FALSE(query.closest({bad, in_a_ball}, 10, kAll, hit));
    }
    EXPECT_FALSE(query.overlap_any({kBall, in_a_ball, Quat(0, 0, 0, 0)}, kAll));
    // An infinite length is valid.
    EXPECT_TRUE(query.ray({Vec3::Zero(), Vec3::UnitX(), INFINITY}, kAll, hit));
    EXPECT_TRUE(query.cast({{kBall}, Vec3::UnitX(), INFINITY}, kAll, hit));
    EXPECT_TRUE(query.closest_to_point(Vec3::Zero(), INFINITY, kAll, hit));
}

TEST(Query, DoesNotAllocate) {
    const Row row(60);
    const Query query = row.scene.query();
    std::array<QueryHit, 16> hits;
    std::array<BodyId, 16> bodies;
    const Shape box = Shape::box(Vec3::Constant(0.4F));
    const std::uint64_t before = allocation_count();
    std::size_t found = 0;
    for (int i = 0; i < 100; ++i) {
        const Vec3 at(static_cast<float>(i), 0.7F, 0.1F);
        found += query.ray({at, Vec3::UnitX(), 10}, kAll, hits[0]) ? 1 : 0;
        found += query.ray_all({at, -Vec3::UnitX(), 200}, kAll, hits).written;
        found += query.cast_all({{box, at}, Vec3(1, -0.1F, 0), 200}, kAll, hits).written;
        found += query.overlap({box, at}, kAll, bodies).written;
        found += query.closest({box, at}, 100, kAll, hits[0]) ? 1 : 0;
    }
    EXPECT_EQ(allocation_count(), before);
    EXPECT_GT(found, 900U);
}

}  // namespace
}  // namespace zoned::physics
