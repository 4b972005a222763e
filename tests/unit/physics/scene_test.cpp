// The promises of a Scene to its callers: ids, refusals, sleep, events, queries, determinism.
#include "server/physics/scene/scene.h"

#include "tests/unit/allocation_count.h"
#include "tests/unit/physics/physics_test.h"
#include "shared/core/rng.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace zoned::physics {
namespace {

BodyId add_floor(Scene& scene) {
    BodyDef def;
    def.kind = BodyKind::kStatic;
    def.shape = Shape::plane();
    return *scene.add(def);
}

BodyDef box_at(const Vec3& x, std::uint32_t user = 0) {
    BodyDef def;
    def.shape = Shape::box(Vec3::Constant(0.5F));
    def.position = x;
    def.user = user;
    return def;
}

BodyDef character_at(const Vec3& x) {
    BodyDef def;
    def.kind = BodyKind::kKinematic;
    def.shape = Shape::capsule(0.4F, 0.5F);
    def.position = x;
    return def;
}

Filter ghost() {
    Filter filter;
    filter.mask = 0;
    return filter;
}

// 5 steps of 1/30 s fall g t^2 / 2 = 0.136 m.
TEST(Scene, LetsASleepingBodyFallThroughWhatItMeetsNoMore) {
    for (const bool of_floor : {false, true}) {
        Scene scene{PhysicsSettings()};
        const BodyId floor = add_floor(scene);
        BodyDef def = box_at(Vec3(0, 0.5F, 0));
        def.asleep = true;
        def.events = kTellEnd;
        const BodyId box = *scene.add(def);
        run_steps(scene, 1, kTick);
        scene.wake(box);
        run_steps(scene, 60, kTick);
        ASSERT_TRUE(scene.state(box).asleep);
        const float before = scene.state(box).position.y();
        scene.set_filter(of_floor ? floor : box, ghost());
        run_steps(scene, 1, kTick);
        ASSERT_EQ(scene.contact_events().size(), 1U);
        EXPECT_TRUE(scene.contact_events()[0].ended);
        run_steps(scene, 4, kTick);
        EXPECT_NEAR(scene.state(box).position.y(), before - 0.136F, 0.002F) << of_floor;
    }
}

// Overlap is undone at 3 m/s: half a metre takes five steps of 1/30 s, and the rest is settling.
TEST(Scene, PushesOutWhoSleepsInABodyThatItMeetsAgain) {
    for (const BodyKind kind : {BodyKind::kStatic, BodyKind::kKinematic, BodyKind::kDynamic}) {
        Scene scene{PhysicsSettings()};
        add_floor(scene);
        BodyDef def = box_at(Vec3(0, 0.25F, 0));
        def.shape = Shape::box(Vec3(2.0F, 0.25F, 2.0F));
        def.mass = 1000.0F;
        def.kind = kind;
        def.filter.category = 2;
        const BodyId slab = *scene.add(def);
        def = box_at(Vec3(0, 0.5F, 0));
        def.filter.mask = 1;
        const BodyId box = *scene.add(def);
        run_steps(scene, 90, kTick);
        ASSERT_TRUE(scene.state(box).asleep);
        ASSERT_NEAR(scene.state(box).position.y(), 0.5F, 0.01F);
        if (kind == BodyKind::kDynamic) {
            scene.set_filter(box, Filter());
        } else {
            scene.set_filter(slab, Filter());
        }
        run_steps(scene, 45, kTick);
        EXPECT_NEAR(scene.state(box).position.y(), 1.0F, 0.02F) << static_cast<int>(kind);
    }
}

TEST(Scene, RefusesWhatIsNotFiniteOrNotPositive) {
    Scene scene{PhysicsSettings()};
    const auto refused = [&](auto&& spoil) {
        BodyDef def = box_at(Vec3::Zero());
        spoil(def);
        return !scene.add(def).ok();
    };
    EXPECT_TRUE(refused([](BodyDef& d) { d.position.x() = kNan; }));
    EXPECT_TRUE(refused([](BodyDef& d) { d.position.y() = INFINITY; }));
    EXPECT_TRUE(refused([](BodyDef& d) { d.velocity.z() = kNan; }));
    EXPECT_TRUE(refused([](BodyDef& d) { d.angular_velocity.z() = 1e30F; }));
    EXPECT_TRUE(refused([](BodyDef& d) { d.mass = 0; }));
    EXPECT_TRUE(refused([](BodyDef& d) { d.mass = -1; }));
    EXPECT_TRUE(refused([](BodyDef& d) { d.mass = kNan; }));
    EXPECT_TRUE(refused([](BodyDef& d) { d.shape.half_extents.y() = 0; }));
    EXPECT_TRUE(refused([](BodyDef& d) { d.shape = Shape::sphere(-1); }));
    EXPECT_TRUE(refused([](BodyDef& d) { d.shape = Shape::capsule(0.5F, kNan); }));
    EXPECT_TRUE(refused([](BodyDef& d) { d.shape = Shape::plane(); }));
    EXPECT_TRUE(refused([](BodyDef& d) { d.orientation = Quat(2, 0, 0, 0); }));
    EXPECT_TRUE(refused([](BodyDef& d) { d.orientation = Quat(kNan, 0, 0, 0); }));
    EXPECT_TRUE(refused([](BodyDef& d) { d.material.friction = -0.1F; }));
    EXPECT_TRUE(refused([](BodyDef& d) { d.material.restitution = 1.5F; }));
    EXPECT_TRUE(refused([](BodyDef& d) { d.shape.kind = static_cast<ShapeKind>(9); }));
    EXPECT_EQ(scene.body_count(), 0U);
}

TEST(Scene, IdsOfRemovedBodiesAreDeadThoughRowsAreReused) {
    Scene scene{PhysicsSettings()};
    const BodyId first = *scene.add(box_at(Vec3::Zero()));
    scene.remove(first);
    const BodyId second = *scene.add(box_at(Vec3::Zero()));
    EXPECT_NE(first, second);
    EXPECT_EQ(first.value & 0xFFFFFU, second.value & 0xFFFFFU);
    EXPECT_FALSE(scene.contains(first));
    EXPECT_TRUE(scene.contains(second));
    EXPECT_FALSE(scene.contains(BodyId()));
    EXPECT_FALSE(scene.contains(BodyId(0xFFFFFFFFU)));
}

TEST(Sleep, SceneAtRestIsSkippedAndWakesByImpulse) {
    Scene scene{PhysicsSettings()};
    add_floor(scene);
    const BodyId box = *scene.add(box_at(Vec3(0, 0.5F, 0)));
    run_steps(scene, 60, kTick);
    EXPECT_EQ(scene.awake_count(), 0U);
    EXPECT_TRUE(scene.state(box).asleep);
    EXPECT_TRUE(scene.step(kTick).skipped);
    EXPECT_TRUE(scene.moved().empty());
    scene.set_velocity(box, Vec3::Zero(), Vec3::Zero());  // no change: sleeps on
    EXPECT_EQ(scene.awake_count(), 0U);
    scene.apply_impulse(box, Vec3(0, 3, 0), scene.state(box).position);
    EXPECT_EQ(scene.awake_count(), 1U);
    EXPECT_FALSE(scene.step(kTick).skipped);
    ASSERT_EQ(scene.moved().size(), 1U);
    EXPECT_EQ(scene.moved()[0], box);
}

TEST(Sleep, RemovalOfTheSupportWakesTheWholeStack) {
    Scene scene{PhysicsSettings()};
    add_floor(scene);
    std::vector<BodyId> boxes;
    for (int i = 0; i < 4; ++i) {
        boxes.push_back(*scene.add(box_at(Vec3(0, 0.5F + static_cast<float>(i), 0))));
    }
    run_steps(scene, 120, kTick);
    ASSERT_EQ(scene.awake_count(), 0U);
    scene.remove(boxes[0]);
    EXPECT_EQ(scene.awake_count(), 3U);
    run_steps(scene, 60, kTick);
    EXPECT_NEAR(scene.state(boxes[3]).position.y(), 2.5F, 0.02F);
}

TEST(Sleep, ATouchWakesTheIslandAndNobodyElse) {
    Scene scene{PhysicsSettings()};
    add_floor(scene);
    const BodyId a = *scene.add(box_at(Vec3(0, 0.5F, 0)));
    const BodyId on_a = *scene.add(box_at(Vec3(0, 1.5F, 0)));
    const BodyId far = *scene.add(box_at(Vec3(5, 0.5F, 0)));
    run_steps(scene, 120, kTick);
    ASSERT_EQ(scene.awake_count(), 0U);
    BodyDef ball;
    ball.shape = Shape::sphere(0.3F);
    ball.position = Vec3(-2, 0.5F, 0);
    ball.velocity = Vec3(10, 0, 0);
    ball.mass = 2.0F;
    ASSERT_TRUE(scene.add(ball).ok());
    run_steps(scene, 6, kTick);
    EXPECT_FALSE(scene.state(a).asleep);
    EXPECT_FALSE(scene.state(on_a).asleep);
    EXPECT_TRUE(scene.state(far).asleep);
}

TEST(Sleep, BodiesAddedAsleepKnowTheirNeighboursWhenWoken) {
    Scene scene{PhysicsSettings()};
    add_floor(scene);
    std::vector<BodyId> boxes;
    for (int i = 0; i < 3; ++i) {
        BodyDef def = box_at(Vec3(0, 0.499F + 0.999F * static_cast<float>(i), 0));
        def.asleep = true;
        boxes.push_back(*scene.add(def));
    }
    EXPECT_TRUE(scene.step(kTick).skipped);
    scene.wake(boxes[2]);
    scene.step(kTick);
    EXPECT_EQ(scene.awake_count(), 3U);
    std::vector<BodyId> island;
    scene.island_of(boxes[1], island);
    EXPECT_EQ(island, boxes);
}

TEST(Kinematic, PushesAndWakesWhatItRunsInto) {
    Scene scene{PhysicsSettings()};
    add_floor(scene);
    const BodyId box = *scene.add(box_at(Vec3(2, 0.5F, 0)));
    const BodyId walker = *scene.add(character_at(Vec3(0, 0.9F, 0)));
    run_steps(scene, 60, kTick);
    ASSERT_TRUE(scene.state(box).asleep);
    EXPECT_TRUE(scene.step(kTick).skipped);
    for (int i = 0; i < 30; ++i) {
        scene.set_velocity(walker, Vec3(3, 0, 0), Vec3::Zero());
        scene.step(kTick);
    }
    // The walker follows its input, and the box is at its front or beyond.
    EXPECT_NEAR(scene.state(walker).position.x(), 3.0F, 1e-4F);
    EXPECT_GT(scene.state(box).position.x(), 3.0F + 0.4F + 0.5F - 0.02F);
}

TEST(Kinematic, LiftCarriesASleepingBox) {
    Scene scene{PhysicsSettings()};
    BodyDef lift;
    lift.kind = BodyKind::kKinematic;
    lift.shape = Shape::box(Vec3(2, 0.1F, 2));
    const BodyId platform = *scene.add(lift);
    const BodyId box = *scene.add(box_at(Vec3(0, 0.6F, 0)));
    run_steps(scene, 60, kTick);
    ASSERT_TRUE(scene.state(box).asleep);
    scene.set_velocity(platform, Vec3(0, 1, 0), Vec3::Zero());
    run_steps(scene, 60, kTick);
    EXPECT_FALSE(scene.state(box).asleep);
    EXPECT_NEAR(scene.state(box).position.y(), 2.6F, 0.02F);
}

TEST(Teleport, WakesWhatWasTouchedAndFindsNewPartners) {
    Scene scene{PhysicsSettings()};
    add_floor(scene);
    const BodyId lower = *scene.add(box_at(Vec3(0, 0.5F, 0), 1));
    const BodyId upper = *scene.add(box_at(Vec3(0, 1.5F, 0), 2));
    run_steps(scene, 90, kTick);
    ASSERT_EQ(scene.awake_count(), 0U);
    BodyState state = scene.state(lower);
    state.asleep = false;
    state.position = Vec3(20, 3, 0);
    scene.set_state(lower, state);
    EXPECT_EQ(scene.awake_count(), 2U);
    run_steps(scene, 90, kTick);
    EXPECT_NEAR(scene.state(upper).position.y(), 0.5F, 0.01F);
    EXPECT_NEAR(scene.state(lower).position.y(), 0.5F, 0.01F);
    EXPECT_NEAR(scene.state(lower).position.x(), 20.0F, 0.01F);
    // A small correction of a body that touches is no new touch.
    state = scene.state(lower);
    state.position.x() += 0.01F;
    state.asleep = false;
    scene.set_state(lower, state);
    scene.step(kTick);
    EXPECT_TRUE(scene.contact_events().empty());
}

TEST(Kinematic, NeverPairsWithStaticOrKinematic) {
    Scene scene{PhysicsSettings()};
    add_floor(scene);
    BodyDef slab;
    slab.kind = BodyKind::kStatic;
    slab.shape = Shape::box(Vec3(150, 0.5F, 150));
    ASSERT_TRUE(scene.add(slab).ok());
    for (int i = 0; i < 20; ++i) {
        BodyDef def = character_at(Vec3(0.1F * static_cast<float>(i), 0.9F, 0));
        def.velocity = Vec3(1, 0, 0);
        ASSERT_TRUE(scene.add(def).ok());
    }
    const StepStats stats = scene.step(kTick);
    EXPECT_FALSE(stats.skipped);
    EXPECT_EQ(stats.pairs, 0U);
    EXPECT_EQ(scene.moved().size(), 20U);
}

TEST(Events, TellWhenAPairBeginsToTouchHowFastAndHowHard) {
    PhysicsSettings s;
    s.gravity = Vec3::Zero();
    Scene scene(s);
    BodyDef a;
    a.shape = Shape::sphere(0.5F);
    a.mass = 2.0F;
    a.position = Vec3(-2, 0, 0);
    a.velocity = Vec3(3, 0, 0);
    a.user = 7;
    BodyDef b = a;
    b.mass = 6.0F;
    b.position = Vec3(0, 0, 0);
    b.velocity = Vec3::Zero();
    b.user = 9;
    const BodyId id_a = *scene.add(a);
    const BodyId id_b = *scene.add(b);
    int events = 0;
    for (int i = 0; i < 30; ++i) {
        scene.step(kTick);
        for (const ContactEvent& e : scene.contact_events()) {
            ++events;
            EXPECT_EQ(e.a, id_a);
            EXPECT_EQ(e.b, id_b);
            EXPECT_EQ(e.user_a, 7U);
            EXPECT_EQ(e.user_b, 9U);
            EXPECT_TRUE(e.began);
            EXPECT_NEAR(e.approach_speed, 3.0F, 1e-5F);
            // Inelastic: both end at the common velocity, the impulse is the reduced mass times it.
            EXPECT_NEAR(e.impulse, 3.0F * 2.0F * 6.0F / 8.0F, 1e-4F);
            EXPECT_NEAR(e.normal.x(), 1.0F, 1e-5F);
        }
    }
    EXPECT_EQ(events, 1);
    EXPECT_NEAR(scene.state(id_a).velocity.x(), 0.75F, 1e-5F);
    EXPECT_NEAR(scene.state(id_b).velocity.x(), 0.75F, 1e-5F);
}

TEST(Quarantine, StopsABodyWhoseStateIsNotFiniteAndHarmsNobody) {
    Scene scene{PhysicsSettings()};
    add_floor(scene);
    const BodyId sick = *scene.add(box_at(Vec3(0, 0.5F, 0)));
    const BodyId well = *scene.add(box_at(Vec3(0, 1.5F, 0)));
    run_steps(scene, 5, kTick);
    scene.apply_impulse(sick, Vec3(1e38F, 1e38F, 0), Vec3(0, 1e20F, 0));
    EXPECT_EQ(scene.step(kTick).quarantined, 1U);
    scene.set_velocity(sick, Vec3(kNan, 0, 0), Vec3::Zero());
    BodyState bad;
    bad.position = Vec3(0, kNan, 0);
    scene.set_state(sick, bad);
    EXPECT_EQ(scene.step(kTick).quarantined, 2U);
    run_steps(scene, 60, kTick);
    for (const BodyId id : {sick, well}) {
        const BodyState state = scene.state(id);
        EXPECT_TRUE(state.position.allFinite() && state.velocity.allFinite());
    }
    EXPECT_NEAR(scene.state(well).position.y(), 1.5F, 0.02F);
    EXPECT_NEAR(scene.state(sick).position.y(), 0.5F, 0.02F);
}

TEST(Quarantine, CatchesABodyThatFallsOutOfTheWorld) {
    Scene scene{PhysicsSettings()};
    BodyDef def = box_at(Vec3(0, -999990.0F, 0));
    def.velocity = Vec3(0, -5000, 0);
    const BodyId id = *scene.add(def);
    std::uint32_t stopped = 0;
    for (int i = 0; i < 10; ++i) {
        stopped += scene.step(kTick).quarantined;
    }
    EXPECT_EQ(stopped, 1U);
    EXPECT_TRUE(scene.state(id).asleep);
    EXPECT_TRUE(scene.state(id).position.allFinite());
}

TEST(RayCast, FindsTheNearestOfAllKindsAndSkipsTheIgnored) {
    Scene scene{PhysicsSettings()};
    const BodyId floor = add_floor(scene);
    BodyDef wall;
    wall.kind = BodyKind::kStatic;
    wall.shape = Shape::box(Vec3(0.5F, 2, 2));
    wall.position = Vec3(10, 2, 0);
    const BodyId wall_id = *scene.add(wall);
    const BodyId box = *scene.add(box_at(Vec3(5, 1, 0), 42));
    const BodyId walker = *scene.add(character_at(Vec3(3, 1, 0)));
    RayHit hit;
    ASSERT_TRUE(scene.ray_cast(Vec3(0, 1, 0), Vec3(2, 0, 0), 100, 0, hit));
    EXPECT_EQ(hit.body, walker);
    EXPECT_NEAR(hit.distance, 2.6F, 1e-5F);
    EXPECT_NEAR(hit.normal.x(), -1.0F, 1e-5F);
    scene.remove(walker);
    ASSERT_TRUE(scene.ray_cast(Vec3(0, 1, 0), Vec3(1, 0, 0), 100, 0, hit));
    EXPECT_EQ(hit.body, box);
    EXPECT_EQ(hit.user, 42U);
    EXPECT_NEAR(hit.distance, 4.5F, 1e-5F);
    ASSERT_TRUE(scene.ray_cast(Vec3(0, 1, 0), Vec3(1, 0, 0), 100, 42, hit));
    EXPECT_EQ(hit.body, wall_id);
    EXPECT_NEAR(hit.distance, 9.5F, 1e-5F);
    EXPECT_FALSE(scene.ray_cast(Vec3(0, 1, 0), Vec3(1, 0, 0), 4.4F, 0, hit));
    ASSERT_TRUE(scene.ray_cast(Vec3(0, 3, 5), Vec3(0, -1, 0), INFINITY, 0, hit));
    EXPECT_EQ(hit.body, floor);
    EXPECT_NEAR(hit.distance, 3.0F, 1e-6F);
    EXPECT_FALSE(scene.ray_cast(Vec3(0, kNan, 0), Vec3(1, 0, 0), 10, 0, hit));
    EXPECT_FALSE(scene.ray_cast(Vec3(0, 1, 0), Vec3::Zero(), 10, 0, hit));
    EXPECT_FALSE(scene.ray_cast(Vec3(0, 1, 0), Vec3(1, 0, 0), kNan, 0, hit));
}

TEST(Overlap, ListsBodiesWhoseBoxesMeetTheArea) {
    Scene scene{PhysicsSettings()};
    const BodyId floor = add_floor(scene);
    const BodyId a = *scene.add(box_at(Vec3(0, 3, 0)));
    const BodyId b = *scene.add(box_at(Vec3(2, 3, 0)));
    std::vector<BodyId> found;
    scene.overlap({Vec3(-1, 2, -1), Vec3(1, 4, 1)}, found);
    EXPECT_EQ(found, std::vector<BodyId>{a});
    found.clear();
    scene.overlap({Vec3(-1, -1, -1), Vec3(3, 4, 1)}, found);
    EXPECT_EQ(found, (std::vector<BodyId>{floor, a, b}));
}

/// A lively scene with everything in it, driven by a seed.
std::vector<std::uint64_t> run_scene(int ticks, bool count_allocations) {
    core::Rng rng(99);
    Scene scene{PhysicsSettings()};
    add_floor(scene);
    std::vector<BodyId> props;
    std::vector<BodyId> walkers;
    for (int i = 0; i < 150; ++i) {
        BodyDef def = box_at(Vec3(rng.range(-6, 6), rng.range(0.6F, 8), rng.range(-6, 6)), 1);
        def.shape = i % 3 == 0   ? Shape::sphere(0.4F)
                    : i % 3 == 1 ? Shape::box(Vec3(0.3F, 0.4F, 0.5F))
                                 : Shape::capsule(0.3F, 0.4F);
        def.material.restitution = i % 5 == 0 ? 0.5F : 0.0F;
        props.push_back(*scene.add(def));
    }
    for (int i = 0; i < 10; ++i) {
        walkers.push_back(*scene.add(character_at(Vec3(rng.range(-6, 6), 0.9F, rng.range(-6, 6)))));
    }
    std::vector<std::uint64_t> hashes;
    hashes.reserve(static_cast<std::size_t>(ticks));
    for (int t = 0; t < ticks; ++t) {
        for (const BodyId w : walkers) {
            // Back and forth, so that after some seconds the scene sees nothing new.
            const float phase = static_cast<float>(t % 60) / 60.0F * 6.2831853F;
            scene.set_velocity(w, Vec3(3 * std::cos(phase), 0, 3 * std::sin(phase)), Vec3::Zero());
        }
        const std::uint64_t before = allocation_count();
        scene.step(kTick);
        if (count_allocations && t >= ticks / 2) {
            EXPECT_EQ(allocation_count(), before) << "tick " << t;
        }
        core::StateHash hash;
        scene.hash(hash);
        hashes.push_back(hash.value());
    }
    return hashes;
}

TEST(Determinism, TheSameCallsGiveTheSameBits) {
    EXPECT_EQ(run_scene(150, false), run_scene(150, false));
}

TEST(Step, DoesNotAllocateAfterWarmUp) {
    run_scene(600, true);
}

TEST(Hash, SeesTheSmallestChange) {
    const auto hash_of = [](float y) {
        Scene scene{PhysicsSettings()};
        (void)scene.add(box_at(Vec3(0, y, 0)));
        core::StateHash hash;
        scene.hash(hash);
        return hash.value();
    };
    EXPECT_EQ(hash_of(1.0F), hash_of(1.0F));
    EXPECT_NE(hash_of(1.0F), hash_of(std::nextafter(1.0F, 2.0F)));
}

}  // namespace
}  // namespace zoned::physics
