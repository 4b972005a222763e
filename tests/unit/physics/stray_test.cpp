// Contacts of bodies that stray far from each other within a step.
#include "tests/unit/physics/joint_scene.h"
#include "shared/core/rng.h"

#include <array>

namespace zoned::physics {
namespace {

Quat any_orientation(core::Rng& rng) {
    const float w = rng.range(-1.0F, 1.0F);
    const float x = rng.range(-1.0F, 1.0F);
    const float y = rng.range(-1.0F, 1.0F);
    const float z = rng.range(-1.0F, 1.0F);
    return Quat(w, x, y, z).normalized();
}

/// Energy after two turned boxes of 0.2 m met head on at `speed` m/s each, as a share of before.
double energy_left(std::uint64_t seed, float speed) {
    core::Rng rng(seed);
    JointScene world;
    for (const float side : {-1.0F, 1.0F}) {
        BodyDef def;
        def.shape = Shape::box(Vec3::Constant(0.1F));
        def.position = Vec3(side * (0.3F + speed * kFrame), 0.03F * side, 0.0F);
        def.velocity = Vec3(-side * speed, 0.0F, 0.0F);
        def.orientation = any_orientation(rng);
        world.add(def);
    }
    const double before = world.sums().energy;
    double most = 0.0;
    for (int i = 0; i < 6; ++i) {
        EXPECT_EQ(world.scene.step(kFrame).quarantined, 0U) << seed;
        most = std::max(most, world.sums().energy / before);
    }
    return most;
}

TEST(StrayingBodies, GainNoEnergyInAFastImpactWithTiltedFaces) {
    // Nothing bounces here: an impact can only take energy away; 1e-5 is the rounding of floats.
    // With masses of the arms at the time of contact some of these are thrown apart.
    for (const float speed : {10.0F, 50.0F, 100.0F, 200.0F}) {
        for (std::uint64_t seed = 0; seed < 40; ++seed) {
            EXPECT_LE(energy_left(seed, speed), 1.0 + 1.0e-5) << seed << " at " << speed;
        }
    }
}

TEST(CrowdedBodies, CostABoundedStep) {
    // 300 spheres in one place have some 40,000 contacts: 64 substeps would be 3 million visits.
    JointScene world(Vec3(0.0F, -kGravity, 0.0F));
    for (int i = 0; i < 300; ++i) {
        world.add(Shape::sphere(0.5F), 1.0F, Vec3(0.001F * static_cast<float>(i), 5.0F, 0.0F));
    }
    const StepStats stats = world.scene.step(kFrame);
    EXPECT_GT(stats.contacts, 30'000U);
    EXPECT_LE(stats.contact_sweeps, 1U << 20);
}

TEST(Sweeps, AreCountedIslandByIsland) {
    JointScene world(Vec3(0.0F, -kGravity, 0.0F));
    BodyDef ground;
    ground.kind = BodyKind::kStatic;
    ground.shape = Shape::plane();
    world.add(ground);
    const Shape box = Shape::box(Vec3::Constant(0.5F));
    for (int k = 0; k < 10; ++k) {
        world.add(box, 1.0F, Vec3(0.0F, 0.5F + static_cast<float>(k), 0.0F));
    }
    const auto alone = [&] {
        world.run(1.0F);
        return world.scene.step(kFrame);
    };
    const StepStats pile = alone();
    EXPECT_EQ(pile.contact_sweeps, std::uint64_t{pile.contacts} * pile.substeps);
    EXPECT_EQ(pile.joint_sweeps, 0U);
    // Nine boxes beside the pile need the fewest substeps there are at this frame, 4 of 1/240 s.
    for (int i = 1; i < 10; ++i) {
        world.add(box, 1.0F, Vec3(3.0F * static_cast<float>(i), 0.5F, 0.0F));
    }
    const StepStats both = alone();
    EXPECT_EQ(both.contacts, pile.contacts + 36U);
    EXPECT_EQ(both.substeps, pile.substeps);
    EXPECT_EQ(both.contact_sweeps, pile.contact_sweeps + 36U * 4U);
}

}  // namespace
}  // namespace zoned::physics
