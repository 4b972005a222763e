// A body between two movers does not fly off.
#include "tests/unit/physics/physics_test.h"
#include "shared/core/rng.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace zoned::physics {
namespace {

constexpr float kMover_mps = 5.0F;

/// A step gives a body across its way no more than a blow of a mover, and 3 m/s by which overlaps
/// end. It is between movers for less than ten steps, and falls for less than a second.
float most_mps(float restitution) {
    return std::sqrt(10.0F) * ((1.0F + restitution) * kMover_mps + 3.0F) + kGravity * 1.0F;
}

/// Two capsules, as tall as people, that run at each other with a box between them.
struct Crush {
    Crush(std::uint64_t seed, float restitution) : scene(PhysicsSettings()) {
        core::Rng rng(seed);
        BodyDef ground;
        ground.kind = BodyKind::kStatic;
        ground.shape = Shape::plane();
        (void)scene.add(ground);
        BodyDef box;
        const Vec3 half(rng.range(0.1F, 0.3F), rng.range(0.2F, 0.5F), rng.range(0.1F, 0.3F));
        radius = half.norm();
        box.shape = Shape::box(half);
        box.mass = rng.range(1.0F, 300.0F);
        box.material.restitution = restitution;
        box.position = Vec3(0.0F, rng.range(0.6F, 1.2F), 0.0F);
        body = *scene.add(box);
        for (const float side : {-1.0F, 1.0F}) {
            BodyDef mover;
            mover.kind = BodyKind::kKinematic;
            mover.shape = Shape::capsule(0.4F, 0.5F);
            mover.position = Vec3(1.5F * side, 0.9F, rng.range(-0.15F, 0.15F));
            mover.velocity = Vec3(-side * kMover_mps, 0.0F, 0.0F);
            (void)scene.add(mover);
        }
    }

    /// Notes the fastest that the box and its corners are, m/s.
    void run() {
        for (int i = 0; i < 60; ++i) {
            scene.step(kTick);
            fastest = std::max(fastest, scene.state(body).velocity.norm());
            corners = std::max(corners, radius * scene.state(body).angular_velocity.norm());
        }
    }

    Scene scene;
    BodyId body;
    float radius = 0.0F;
    float fastest = 0.0F;
    float corners = 0.0F;
};

TEST(Squeezed, LeaveNoFasterThanABlowOfTheFastestMover) {
    for (const float restitution : {0.0F, 0.1F, 0.5F, 1.0F}) {
        for (std::uint64_t seed = 1; seed <= 300; ++seed) {
            Crush crush(seed, restitution);
            crush.run();
            EXPECT_LE(crush.fastest, most_mps(restitution)) << seed << " " << restitution;
            EXPECT_LE(crush.corners, 2.0F * most_mps(restitution)) << seed << " " << restitution;
        }
    }
}

/// A body on level ground that a mover comes towards along x.
struct Push {
    explicit Push(const BodyDef& def) : scene(PhysicsSettings()) {
        BodyDef ground;
        ground.kind = BodyKind::kStatic;
        ground.shape = Shape::plane();
        (void)scene.add(ground);
        body = *scene.add(def);
        BodyDef wall;
        wall.kind = BodyKind::kKinematic;
        wall.shape = Shape::box(Vec3(0.25F, 1.0F, 2.0F));
        wall.position = Vec3(-1.5F, 1.0F, 0.0F);
        wall.velocity = Vec3(kMover_mps, 0.0F, 0.0F);
        (void)scene.add(wall);
    }

    Scene scene;
    BodyId body;
};

TEST(Squeezed, AreNotWhatALoneMoverPushesAlongTheGround) {
    BodyDef box;
    box.shape = Shape::box(Vec3(0.25F, 0.25F, 0.25F));
    box.mass = 10.0F;
    box.position = Vec3(0.0F, 0.25F, 0.0F);
    Push push(box);
    run_steps(push.scene, 60, kTick);
    EXPECT_NEAR(push.scene.state(push.body).velocity.x(), kMover_mps, 0.1F);
}

TEST(Squeezed, AreNotLogsThatRoll) {
    // A log that is pushed along rolls at up to 5 m/s over 0.1 m, which its far ends do not limit.
    BodyDef log;
    log.shape = Shape::capsule(0.1F, 1.0F);
    log.mass = 20.0F;
    log.position = Vec3(0.0F, 0.1F, 0.0F);
    log.orientation = Quat(std::sqrt(0.5F), std::sqrt(0.5F), 0.0F, 0.0F);  // along z
    log.material.friction = 1.0F;
    Push push(log);
    run_steps(push.scene, 90, kTick);
    EXPECT_GT(push.scene.state(push.body).angular_velocity.norm(), 20.0F);
}

}  // namespace
}  // namespace zoned::physics
