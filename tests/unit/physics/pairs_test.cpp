// How a scene finds the pairs of its bodies: the same whatever structure finds them.
#include "server/physics/scene/scene.h"
#include "tests/unit/physics/physics_test.h"
#include "shared/core/rng.h"

#include <gtest/gtest.h>

#include <string>
#include <vector>

namespace zoned::physics {
namespace {

BodyDef body_at(const Vec3& x, int i) {
    BodyDef def;
    def.position = x;
    def.shape = i % 3 == 0   ? Shape::sphere(0.4F)
                : i % 3 == 1 ? Shape::box(Vec3(0.3F, 0.4F, 0.5F))
                             : Shape::capsule(0.3F, 0.4F);
    return def;
}

void add_ground(Scene& scene, bool plane) {
    BodyDef def;
    def.kind = BodyKind::kStatic;
    def.shape = plane ? Shape::plane() : Shape::box(Vec3(50, 1, 50));
    def.position = plane ? Vec3::Zero() : Vec3(0, -1, 0);
    ASSERT_TRUE(scene.add(def).ok());
}

/// Hashes of a scene in which bodies of all kinds come, go, fall, are pushed and teleported.
std::vector<std::uint64_t> lively(BroadphaseKind kind) {
    PhysicsSettings settings;
    settings.broadphase = kind;
    Scene scene(settings);
    core::Rng rng(4);
    std::vector<BodyId> bodies;
    add_ground(scene, false);
    const auto add = [&](int i) {
        BodyDef def = body_at(Vec3(rng.range(-6, 6), rng.range(0.6F, 8), rng.range(-6, 6)), i);
        def.kind = i % 11 == 0   ? BodyKind::kKinematic
                   : i % 13 == 0 ? BodyKind::kStatic
                                 : BodyKind::kDynamic;
        if (def.kind != BodyKind::kStatic) {
            def.velocity = Vec3(rng.range(-3, 3), 0, rng.range(-3, 3));
            def.angular_velocity = Vec3(rng.range(-9, 9), rng.range(-9, 9), 0);
        }
        bodies.push_back(*scene.add(def));
    };
    for (int i = 0; i < 150; ++i) {
        add(i);
    }
    std::vector<std::uint64_t> hashes;
    for (int t = 0; t < 240; ++t) {
        const std::size_t chosen = rng.below(static_cast<std::uint32_t>(bodies.size()));
        if (t % 5 == 0) {
            BodyState state = scene.state(bodies[chosen]);
            state.position += Vec3(rng.range(-4, 4), rng.range(0, 4), rng.range(-4, 4));
            scene.set_state(bodies[chosen], state);
        } else if (t % 7 == 0) {
            scene.remove(bodies[chosen]);
            bodies.erase(bodies.begin() + static_cast<std::ptrdiff_t>(chosen));
            add(t);
        }
        scene.step(kFrame);
        core::StateHash hash;
        scene.hash(hash);
        hashes.push_back(hash.value());
    }
    return hashes;
}

TEST(Pairs, AreTheSameForEveryBroadphase) {
    const std::vector<std::uint64_t> expected = lively(BroadphaseKind::kAllPairs);
    for (const BroadphaseKind kind : {BroadphaseKind::kAutomatic,
                                      BroadphaseKind::kGrid,
                                      BroadphaseKind::kOctree,
                                      BroadphaseKind::kQuadtree,
                                      BroadphaseKind::kSortAndSweep,
                                      BroadphaseKind::kTree}) {
        EXPECT_EQ(lively(kind), expected) << spatial::name_of(kind);
    }
}

TEST(Pairs, OfACrowdInOnePlaceAreCappedAndReportedAndNobodyFallsThroughTheFloor) {
    PhysicsSettings settings;
    settings.max_pairs = 11000;
    Scene scene(settings);
    add_ground(scene, false);
    std::vector<BodyId> crowd;
    for (int i = 0; i < 10000; ++i) {
        crowd.push_back(*scene.add(body_at(Vec3(20, 0.6F, 20), i)));
    }
    std::vector<BodyId> apart;  // with the highest ids, so that they wait longest
    for (int i = 0; i < 10; ++i) {
        apart.push_back(*scene.add(body_at(Vec3(3.0F * static_cast<float>(i) - 40, 0.6F, -20), 1)));
    }
    for (int t = 0; t < 20; ++t) {
        const StepStats stats = scene.step(kFrame);
        EXPECT_GT(stats.unpaired, 9000U);
        EXPECT_GE(stats.pairs, 11000U);
        EXPECT_LE(stats.pairs, 11000U + 10010U);  // each with the floor besides
    }
    for (const BodyId id : apart) {
        EXPECT_NEAR(scene.state(id).position.y(), 0.4F, 0.05F);
    }
}

TEST(Pairs, ThatFoundNoRoomAreFoundOnceOthersHaveParted) {
    PhysicsSettings settings;
    settings.max_pairs = 40;
    settings.gravity = Vec3::Zero();
    Scene scene(settings);
    std::vector<BodyId> crowd;
    for (int i = 0; i < 30; ++i) {
        crowd.push_back(*scene.add(body_at(Vec3::Zero(), 0)));
    }
    // Two more, the last of all, are about to touch.
    BodyDef def = body_at(Vec3(30, 0, 0), 0);
    const BodyId still = *scene.add(def);
    def.position.x() = 32;
    def.velocity.x() = -1.0F;
    const BodyId moving = *scene.add(def);
    EXPECT_GT(scene.step(kFrame).unpaired, 0U);
    for (const BodyId id : crowd) {
        scene.remove(id);
    }
    std::uint32_t waiting = 1;
    for (int t = 0; t < 150; ++t) {
        waiting = scene.step(kFrame).unpaired;
    }
    EXPECT_EQ(waiting, 0U);
    EXPECT_GT(scene.state(still).velocity.x() * -1.0F, 0.1F);  // was pushed
    EXPECT_LT(scene.state(moving).position.x(), 32.0F);
}

TEST(Pairs, OfALongBodyThatSpinsFastAreThoseInItsBoundingSphere) {
    PhysicsSettings settings;
    settings.gravity = Vec3::Zero();
    Scene scene(settings);
    BodyDef rod;
    rod.shape = Shape::box(Vec3(2, 0.05F, 0.05F));
    rod.angular_velocity = Vec3(0, 60, 0);
    ASSERT_TRUE(scene.add(rod).ok());
    // Beside the disc that the rod sweeps: above it, and beyond its ends.
    ASSERT_TRUE(scene.add(body_at(Vec3(0, 2.7F, 0), 0)).ok());
    ASSERT_TRUE(scene.add(body_at(Vec3(2, 0, 2), 0)).ok());
    EXPECT_EQ(scene.step(kFrame).pairs, 0U);
    // Within its reach in a step: arc of one radian.
    const BodyId in_the_way = *scene.add(body_at(Vec3(1.2F, 0, 1.0F), 0));
    for (int t = 0; t < 30; ++t) {
        scene.step(kFrame);
    }
    EXPECT_GT(scene.state(in_the_way).velocity.norm(), 0.1F);
}

}  // namespace
}  // namespace zoned::physics
