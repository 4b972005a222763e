#include "server/physics/shapes/compound/compound.h"

#include "server/physics/scene/scene.h"
#include "server/physics/shapes/compound/inertia.h"
#include "server/physics/shapes/mass_properties.h"
#include "tests/unit/allocation_count.h"
#include "tests/unit/physics/hulls.h"
#include "tests/unit/physics/physics_test.h"
#include "tests/unit/physics/surfaces.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace zoned::physics {
namespace {

CompoundPart part(const Shape& shape, const Vec3& at, const Quat& turn = Quat::Identity()) {
    CompoundPart p;
    p.shape = shape;
    p.frame = {at, turn};
    return p;
}

/// A hammer: a light handle along x, a heavy head across its end.
std::vector<CompoundPart> hammer() {
    std::vector<CompoundPart> parts{part(Shape::box({0.5F, 0.05F, 0.05F}), {0, 0, 0}),
                                    part(Shape::box({0.1F, 0.1F, 0.25F}), {0.6F, 0, 0})};
    parts[1].material.density = 4000.0F;
    return parts;
}

BodyDef body_of(const BuiltCompound& built, const Frame& at) {
    BodyDef def;
    def.shape = Shape::compound(built.compound);
    const Frame pose = at * built.frame;
    def.position = pose.position;
    def.orientation = pose.rotation;
    def.mass = built.mass;
    return def;
}

TEST(Compound, OfTwoHalvesOfABoxHasTheBoxsMassAndMoments) {
    const std::vector<CompoundPart> parts{part(Shape::box({0.5F, 1.0F, 1.5F}), {1.5F, 2, 3}),
                                          part(Shape::box({0.5F, 1.0F, 1.5F}), {2.5F, 2, 3})};
    const BuiltCompound built = *build_compound(parts);
    EXPECT_LT((built.frame.position - Vec3(2, 2, 3)).norm(), 1e-6F);
    EXPECT_NEAR(built.frame.rotation.w(), 1.0F, 1e-6F);
    EXPECT_FLOAT_EQ(built.mass, 12.0F * 1000.0F);
    const Vec3 whole = principal_inertia(Shape::box({1.0F, 1.0F, 1.5F}), built.mass);
    const Vec3 got = principal_inertia(Shape::compound(built.compound), built.mass);
    EXPECT_TRUE(got.isApprox(whole, 1e-6F)) << got << "\n" << whole;
}

TEST(Compound, AHammerBalancesAtItsWeightedCentre) {
    const BuiltCompound built = *build_compound(hammer());
    // Volumes 0.01 and 0.02 m3, masses 10 and 80 kg.
    EXPECT_NEAR(built.mass, 90.0F, 1e-3F);
    EXPECT_NEAR(built.frame.position.x(), 0.6F * 80.0F / 90.0F, 1e-6F);
    // About z: both boxes' own moments and the parallel axes.
    const float z = 10.0F / 3.0F * (0.25F + 0.0025F) + 80.0F / 3.0F * (0.01F + 0.01F) +
                    10.0F * 80.0F / 90.0F * 0.36F;
    const Mat3 r(built.frame.rotation);
    const Mat3 tensor =
        rotated_tensor(r, principal_inertia(Shape::compound(built.compound), built.mass));
    EXPECT_NEAR(tensor(2, 2), z, 1e-4F);
    EXPECT_NEAR(tensor(0, 1), 0.0F, 1e-5F);
}

TEST(Compound, TakesAnyTensor) {
    Mat3 tensor;
    tensor << 3.0F, 0.4F, -0.3F, 0.4F, 4.0F, 0.5F, -0.3F, 0.5F, 5.0F;
    const std::vector<CompoundPart> parts{part(Shape::sphere(0.5F), Vec3::Zero())};
    const BuiltCompound built = *build_compound(parts, 10.0F, Vec3(0, 0.1F, 0), tensor);
    const Mat3 r(built.frame.rotation);
    const Vec3 moments = principal_inertia(Shape::compound(built.compound), 10.0F);
    EXPECT_TRUE(rotated_tensor(r, moments).isApprox(tensor, 1e-5F));
    // The part stays where it was given, although the frame has turned and shifted.
    const Compound::CompoundChild& stored = built.compound->parts()[0];
    EXPECT_LT((built.frame * stored.part.frame).position.norm(), 1e-6F);
    tensor(0, 0) = 10.0F;
    const auto refused = build_compound(parts, 10.0F, Vec3::Zero(), tensor);
    ASSERT_FALSE(refused);
    EXPECT_TRUE(refused.error().starts_with(
        "compound: inertia: a moment exceeds the sum of the other two: "));
}

TEST(Compound, RefusesWhatIsNoBody) {
    const auto reason = [](const std::vector<CompoundPart>& parts) {
        const auto built = build_compound(parts);
        return built ? std::string() : built.error();
    };
    EXPECT_EQ(reason({}), "compound: needs 1..1024 parts");
    EXPECT_EQ(reason({part(Shape::plane(), Vec3::Zero())}),
              "compound: part 0: only spheres, boxes, capsules and hulls can be parts");
    EXPECT_EQ(
        reason({part(Shape::sphere(0.5F), Vec3::Zero()), part(Shape::sphere(-1.0F), Vec3::Zero())}),
        "compound: part 1: sphere: radius out of range");
    const float nan = std::numeric_limits<float>::quiet_NaN();
    EXPECT_EQ(reason({part(Shape::sphere(0.5F), Vec3(nan, 0, 0))}),
              "compound: part 0: position out of range");
    EXPECT_EQ(reason({part(Shape::sphere(0.5F), Vec3::Zero(), Quat(0, 0, 0, 0))}),
              "compound: part 0: orientation is not a unit quaternion");
    Shape empty;
    empty.kind = ShapeKind::kHull;
    EXPECT_EQ(reason({part(empty, Vec3::Zero())}), "compound: part 0: hull: no geometry");
    CompoundPart sensor = part(Shape::sphere(0.5F), Vec3::Zero());
    sensor.sensor = true;
    EXPECT_EQ(reason({sensor}), "compound: no part has a mass");
}

TEST(Compound, OfTwoBoxesStandsAsOneBoxDoes) {
    // Unit cubes of two slabs each, stacked five high, on a plane and on each other.
    const std::vector<CompoundPart> slabs{
        part(Shape::box({0.5F, 0.25F, 0.5F}), {0, -0.25F, 0}),
        part(hull_shape(box_corners({0.5F, 0.25F, 0.5F})), {0, 0.25F, 0})};
    const BuiltCompound built = *build_compound(slabs);
    for (const bool mesh : {false, true}) {
        PhysicsSettings settings;
        settings.sleep_after_s = 0.0F;
        Scene scene(settings);
        add_static(scene,
                   mesh ? mesh_shape(grid_mesh(20, 0.7F, [](float, float) { return 0.0F; }))
                        : Shape::plane());
        std::vector<BodyId> boxes;
        for (int i = 0; i < 5; ++i) {
            BodyDef def = body_of(built, {Vec3(0, 0.5F + static_cast<float>(i), 0)});
            def.mass = 1.0F;
            boxes.push_back(*scene.add(def));
        }
        for (int i = 0; i < 600; ++i) {
            scene.step(kFrame);
        }
        for (int i = 0; i < 5; ++i) {
            const Vec3 x = scene.state(boxes[static_cast<std::size_t>(i)]).position;
            EXPECT_LT((x - Vec3(0, 0.5F + static_cast<float>(i), 0)).norm(), 0.01F) << i;
        }
    }
}

TEST(Compound, FallsAsleepAndWakesLikeAnythingElse) {
    const BuiltCompound built = *build_compound(hammer());
    Scene scene{PhysicsSettings()};
    add_static(scene, field_shape(21, 0.5F, [](float, float) { return 0.0F; }));
    const BodyId id = *scene.add(body_of(built, {Vec3(0, 0.3F, 0)}));
    for (int i = 0; i < 300; ++i) {
        scene.step(kFrame);
    }
    EXPECT_EQ(scene.awake_count(), 0U);
    BodyDef ball;
    ball.shape = Shape::sphere(0.2F);
    ball.position = scene.state(id).position + Vec3(0, 2, 0);
    ASSERT_TRUE(scene.add(ball).ok());
    float largest = 0.0F;
    for (int i = 0; i < 60; ++i) {
        scene.step(kFrame);
        largest = std::max(largest, static_cast<float>(scene.awake_count()));
    }
    EXPECT_EQ(largest, 2.0F);
}

TEST(Compound, TumblesWithoutAllocatingAfterWarmUp) {
    // Hammers, hulls and balls on rough ground, thrown up again and again.
    core::Rng rng(71);
    const BuiltCompound built = *build_compound(hammer());
    PhysicsSettings settings;
    settings.sleep_after_s = 0.0F;
    Scene scene(settings);
    add_static(scene, field_shape(41, 0.5F, [](float x, float z) {
                   return 0.3F * std::sin(2.0F * x) * std::cos(2.0F * z);
               }));
    std::vector<BodyId> bodies;
    for (int i = 0; i < 40; ++i) {
        const float x = rng.range(-5, 5);
        const float z = rng.range(-5, 5);
        const Frame at{Vec3(x, rng.range(1, 4), z), random_rotation(rng)};
        BodyDef def = body_of(built, at);
        if (i % 4 == 1) {
            def.shape = hull_shape(random_points(rng, 12, 0.4F));
        } else if (i % 4 == 2) {
            def.shape = Shape::sphere(0.3F);
        }
        bodies.push_back(*scene.add(def));
    }
    const auto toss = [&] {
        for (const BodyId id : bodies) {
            scene.apply_impulse(id, Vec3(0, 4.0F * 90.0F, 0), scene.state(id).position);
        }
    };
    for (int i = 0; i < 600; ++i) {
        if (i % 120 == 0) {
            toss();
        }
        const std::uint64_t before = allocation_count();
        scene.step(kFrame);
        if (i >= 360) {
            EXPECT_EQ(allocation_count(), before) << i;
        }
    }
    for (const BodyId id : bodies) {
        const Vec3 x = scene.state(id).position;
        EXPECT_TRUE(x.allFinite());
        if (x.cwiseAbs().maxCoeff() < 9.0F) {
            EXPECT_GT(x.y(), -0.4F);
        }
    }
}

TEST(Compound, TheSameCallsGiveTheSameBits) {
    const auto run = [] {
        core::Rng rng(72);
        const BuiltCompound built = *build_compound(hammer());
        Scene scene{PhysicsSettings()};
        add_static(scene, mesh_shape(grid_mesh(20, 0.7F, [](float x, float z) {
                       return 0.2F * std::round(std::abs(x) + std::abs(z));
                   })));
        for (int i = 0; i < 30; ++i) {
            const float x = rng.range(-4, 4);
            const float z = rng.range(-4, 4);
            const Frame at{Vec3(x, rng.range(2, 5), z), random_rotation(rng)};
            EXPECT_TRUE(scene.add(body_of(built, at)).ok());
        }
        for (int i = 0; i < 200; ++i) {
            scene.step(kFrame);
        }
        core::StateHash hash;
        scene.hash(hash);
        return hash.value();
    };
    EXPECT_EQ(run(), run());
}

}  // namespace
}  // namespace zoned::physics
