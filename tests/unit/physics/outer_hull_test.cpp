// A compound as one hull, and bodies that change their shape where they are.
#include "server/physics/shapes/compound/outer_hull.h"

#include "server/physics/shapes/compound/bounds.h"
#include "tests/unit/physics/physics_test.h"

#include <gtest/gtest.h>

namespace zoned::physics {
namespace {

CompoundPart part_at(const Shape& shape, const Vec3& position) {
    CompoundPart part;
    part.shape = shape;
    part.frame.position = position;
    return part;
}

/// A top of 1.6 x 0.06 x 0.9 m on four legs.
BuiltCompound table() {
    std::vector<CompoundPart> parts{
        part_at(Shape::box(Vec3(0.8F, 0.03F, 0.45F)), Vec3(0, 0.74F, 0))};
    for (int i = 0; i < 4; ++i) {
        parts.push_back(part_at(Shape::box(Vec3(0.03F, 0.355F, 0.03F)),
                                Vec3(i % 2 == 0 ? 0.7F : -0.7F, 0.355F, i < 2 ? 0.35F : -0.35F)));
    }
    return *build_compound(parts);
}

BodyDef table_at(const Vec3& position) {
    const BuiltCompound built = table();
    BodyDef def;
    def.shape = Shape::compound(built.compound);
    def.mass = 20.0F;
    def.position = position;
    def.orientation = built.frame.rotation;
    return def;
}

Shape outer_table() {
    return Shape::compound(outer_hull_of(*table().compound)->compound);
}

TEST(Outer, HasTheBoundsAndTheMassPropertiesOfTheCompound) {
    const BuiltCompound built = table();
    const auto outer = outer_hull_of(*built.compound);
    ASSERT_TRUE(outer.ok());
    EXPECT_EQ(outer->compound->parts().size(), 1U);
    EXPECT_EQ(outer->compound->moments_per_kg(), built.compound->moments_per_kg());
    const Mat3 upright = built.frame.rotation.toRotationMatrix();
    const Aabb inner = shape_bounds(Shape::compound(built.compound), Vec3::Zero(), upright);
    const Aabb around = shape_bounds(Shape::compound(outer->compound), Vec3::Zero(), upright);
    EXPECT_TRUE(around.lower.isApprox(inner.lower, 1.0e-5F));
    EXPECT_TRUE(around.upper.isApprox(inner.upper, 1.0e-5F));
    EXPECT_LT(outer->cut_off, 1.0e-5F);
}

/// Two balls and a bar: corners stand for round parts, and the cut-off is reported.
TEST(Outer, TellsWhatItCutsOffOfRoundParts) {
    const std::vector<CompoundPart> parts{part_at(Shape::sphere(0.25F), Vec3(-0.5F, 0, 0)),
                                          part_at(Shape::sphere(0.25F), Vec3(0.5F, 0, 0))};
    const auto outer = outer_hull_of(*build_compound(parts)->compound);
    ASSERT_TRUE(outer.ok());
    const float told = outer->cut_off;
    EXPECT_GT(told, 0.0F);
    EXPECT_LT(told, 0.1F * 0.25F + 0.02F);
}

TEST(Outer, RestsWhereTheCompoundRests) {
    PhysicsSettings settings;
    Scene scene(settings);
    BodyDef ground;
    ground.kind = BodyKind::kStatic;
    ground.shape = Shape::plane();
    ASSERT_TRUE(scene.add(ground).ok());
    const BodyId full = *scene.add(table_at(Vec3(-3, 1, 0)));
    const BodyId single = *scene.add(table_at(Vec3(3, 1, 0)));
    ASSERT_TRUE(scene.set_shape(single, outer_table()).ok());
    run_steps(scene, 180);
    EXPECT_NEAR(
        scene.state(full).position.y(), scene.state(single).position.y(), settings.error_budget_m);
    EXPECT_TRUE(scene.state(single).asleep);
}

TEST(SetShape, KeepsMotionAndMomentum) {
    Scene scene(weightless());
    BodyDef def = table_at(Vec3(1, 2, 3));
    def.velocity = Vec3(1, 2, 3);
    def.angular_velocity = Vec3(0.3F, -1, 2);
    def.user = 7;
    const BodyId changes = *scene.add(def);
    def.position.x() += 50.0F;
    const BodyId stays = *scene.add(def);
    for (int i = 0; i < 60; ++i) {
        if (i % 20 == 10) {
            ASSERT_TRUE(scene.set_shape(changes, i == 30 ? def.shape : outer_table()).ok());
        }
        scene.step(kFrame);
    }
    // The same arithmetic about another origin: only positions round otherwise.
    EXPECT_EQ(scene.state(changes).velocity, scene.state(stays).velocity);
    EXPECT_EQ(scene.state(changes).angular_velocity, scene.state(stays).angular_velocity);
    EXPECT_EQ(scene.state(changes).orientation.coeffs(), scene.state(stays).orientation.coeffs());
    EXPECT_EQ(scene.user(changes), 7U);
}

/// A compound's legs let a ball pass between them; its hull does not.
TEST(SetShape, MeetsOthersAsTheNewShape) {
    for (const bool single : {false, true}) {
        Scene scene(weightless());
        const BodyId body = *scene.add(table_at(Vec3::Zero()));
        if (single) {
            ASSERT_TRUE(scene.set_shape(body, outer_table()).ok());
        }
        BodyDef ball;
        ball.shape = Shape::sphere(0.1F);
        ball.mass = 0.01F;
        ball.position = Vec3(0, -0.2F, -3);
        ball.velocity = Vec3(0, 0, 6);
        const BodyId flies = *scene.add(ball);
        run_steps(scene, 60);
        EXPECT_EQ(scene.state(flies).position.z() > 2.9F, !single);
    }
}

TEST(SetShape, LiftsOutWhatWouldOverlap) {
    Scene scene(weightless());
    BodyDef ground;
    ground.kind = BodyKind::kStatic;
    ground.shape = Shape::box(Vec3(5, 1, 5));
    ground.position = Vec3(0, -1, 0);
    ASSERT_TRUE(scene.add(ground).ok());
    BodyDef ball;
    ball.shape = Shape::sphere(0.1F);
    ball.position = Vec3(0, 0.1F, 0);
    const BodyId grows = *scene.add(ball);
    const auto state = scene.set_shape(grows, Shape::sphere(0.5F));
    ASSERT_TRUE(state.ok());
    EXPECT_NEAR(state->position.y(), 0.5F, 1.0e-3F);
}

TEST(SetShape, RefusesWhatCannotHaveIt) {
    Scene scene(weightless());
    BodyDef wall;
    wall.kind = BodyKind::kStatic;
    const BodyId still = *scene.add(wall);
    const BodyId moves = *scene.add(table_at(Vec3(5, 0, 0)));
    EXPECT_FALSE(scene.set_shape(still, Shape::sphere(1.0F)).ok());
    EXPECT_FALSE(scene.set_shape(BodyId(), Shape::sphere(1.0F)).ok());
    EXPECT_FALSE(scene.set_shape(moves, Shape::plane()).ok());
    EXPECT_FALSE(scene.set_shape(moves, Shape::sphere(kNan)).ok());
    ASSERT_TRUE(scene.set_representation(moves, BodyRepresentation::kParticle).ok());
    EXPECT_FALSE(scene.set_shape(moves, Shape::sphere(1.0F)).ok());
}

}  // namespace
}  // namespace zoned::physics
