// Materials, filters and sensors.
#include "server/physics/shapes/material.h"

#include "server/physics/shapes/compound/body_checks.h"
#include "server/physics/shapes/compound/compound.h"
#include "tests/unit/physics/hulls.h"
#include "tests/unit/physics/physics_test.h"
#include "tests/unit/physics/surfaces.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace zoned::physics {
namespace {

TEST(Combine, AppliesTheLaterRuleOfTheTwo) {
    Material a{0.2F, 0.1F};
    Material b{0.8F, 0.4F};
    EXPECT_FLOAT_EQ(combine(a, b).friction, 0.4F);
    EXPECT_FLOAT_EQ(combine(a, b).restitution, 0.4F);
    const auto with = [&](Combine ra, Combine rb) {
        a.friction_rule = ra;
        a.restitution_rule = ra;
        b.friction_rule = rb;
        b.restitution_rule = rb;
        EXPECT_EQ(combine(a, b).friction, combine(b, a).friction);
        return combine(a, b);
    };
    EXPECT_FLOAT_EQ(with(Combine::kAverage, Combine::kDefault).friction, 0.5F);
    EXPECT_FLOAT_EQ(with(Combine::kAverage, Combine::kMinimum).friction, 0.2F);
    EXPECT_FLOAT_EQ(with(Combine::kMultiply, Combine::kMinimum).friction, 0.16F);
    EXPECT_FLOAT_EQ(with(Combine::kMultiply, Combine::kMaximum).friction, 0.8F);
    EXPECT_FLOAT_EQ(with(Combine::kGeometricMean, Combine::kAverage).restitution, 0.2F);
    EXPECT_FLOAT_EQ(with(Combine::kMinimum, Combine::kDefault).restitution, 0.1F);
}

BodyDef ball_at(const Vec3& x, std::uint32_t user = 0) {
    BodyDef def;
    def.shape = Shape::sphere(0.5F);
    def.position = x;
    def.user = user;
    return def;
}

TEST(Restitution, OfThePartThatTouchesCounts) {
    // One end of a dumbbell bounces, the other does not.
    CompoundPart left;
    left.shape = Shape::sphere(0.2F);
    left.frame.position = Vec3(-1, 0, 0);
    CompoundPart right = left;
    right.frame.position = Vec3(1, 0, 0);
    right.material.restitution = 1.0F;
    const CompoundPart parts[] = {left, right};
    const BuiltCompound built = *build_compound(parts);
    PhysicsSettings settings;
    settings.sleep_after_s = 0.0F;
    Scene scene(settings);
    add_static(scene, Shape::plane(), {0.0F, 0.0F});
    BodyDef def;
    def.shape = Shape::compound(built.compound);
    def.position = Vec3(0, 1.2F, 0);
    const BodyId id = *scene.add(def);
    for (int i = 0; i < 35; ++i) {
        scene.step(kFrame);
    }
    // After the impact the body turns: its right end goes up, its left one stays down.
    const BodyState s = scene.state(id);
    EXPECT_GT(s.angular_velocity.z(), 1.0F);
}

TEST(Filter, LetsPassWhomTheMasksDoNotName) {
    for (const bool meets : {false, true}) {
        Scene scene{PhysicsSettings()};
        BodyDef floor;
        floor.kind = BodyKind::kStatic;
        floor.shape = Shape::plane();
        floor.filter = {2, meets ? 5U : 1U};
        ASSERT_TRUE(scene.add(floor).ok());
        BodyDef ball = ball_at(Vec3(0, 1, 0));
        ball.filter = {4, 2};
        const BodyId id = *scene.add(ball);
        for (int i = 0; i < 60; ++i) {
            scene.step(kFrame);
        }
        EXPECT_EQ(scene.state(id).position.y() > 0.0F, meets);
    }
}

TEST(Filter, OfPartsAppliesToEachPart) {
    // A ghostly ball hangs below a solid one: only the solid one lands.
    CompoundPart solid;
    solid.shape = Shape::sphere(0.2F);
    CompoundPart ghost = solid;
    ghost.frame.position = Vec3(0, -1, 0);
    ghost.filter.mask = 0;
    const CompoundPart parts[] = {solid, ghost};
    const BuiltCompound built = *build_compound(parts);
    CompoundPart slab;
    slab.shape = Shape::box(Vec3(5, 0.5F, 5));
    slab.frame.position = Vec3(0, -0.5F, 0);
    const BuiltCompound ground = *build_compound({&slab, 1});
    Scene scene{PhysicsSettings()};
    BodyDef floor;
    floor.kind = BodyKind::kStatic;
    floor.shape = Shape::compound(ground.compound);
    floor.position = ground.frame.position;
    ASSERT_TRUE(scene.add(floor).ok());
    BodyDef def;
    def.shape = Shape::compound(built.compound);
    def.position = Vec3(0, 1.5F, 0) + built.frame.position;
    def.angular_velocity = Vec3::Zero();
    const BodyId id = *scene.add(def);
    for (int i = 0; i < 120; ++i) {
        scene.step(kFrame);
    }
    const Frame pose{scene.state(id).position, scene.state(id).orientation};
    EXPECT_NEAR((pose * built.compound->parts()[0].part.frame).position.y(), 0.2F, 0.02F);
    EXPECT_LT((pose * built.compound->parts()[1].part.frame).position.y(), -0.2F);
}

TEST(Sensor, ReportsWhoComesAndGoesAndPushesNobody) {
    const Shape box = Shape::box(Vec3(2, 0.5F, 2));
    const Shape hull = hull_shape(box_corners(Vec3(2, 0.5F, 2)));
    for (const Shape& shape : {box, hull}) {
        Scene scene{PhysicsSettings()};
        BodyDef zone;
        zone.kind = BodyKind::kStatic;
        zone.shape = shape;
        zone.sensor = true;
        zone.user = 7;
        const BodyId sensor = *scene.add(zone);
        const BodyId ball = *scene.add(ball_at(Vec3(0, 3, 0), 8));
        int entered = -1;
        int left = -1;
        for (int i = 0; i < 120; ++i) {
            scene.step(kFrame);
            EXPECT_TRUE(scene.contact_events().empty());
            for (const SensorEvent& e : scene.sensor_events()) {
                EXPECT_EQ(e.a, sensor);
                EXPECT_EQ(e.b, ball);
                EXPECT_EQ(e.user_a, 7U);
                EXPECT_EQ(e.user_b, 8U);
                EXPECT_EQ(e.entered ? entered : left, -1);
                (e.entered ? entered : left) = i;
            }
        }
        // Free fall: y = 3 - g t^2 / 2 goes through 1 and -1, seen at the start of the next step.
        EXPECT_NEAR(entered, std::sqrt(2 * 2.0F / 9.81F) / kFrame, 1.5F);
        EXPECT_NEAR(left, std::sqrt(2 * 4.0F / 9.81F) / kFrame, 1.5F);
        EXPECT_NEAR(scene.state(ball).position.y(), 3.0F - 9.81F * 2.0F, 0.01F);
    }
}

TEST(Sensor, IsLeftByWhatIsRemovedOrCarriedOff) {
    Scene scene{PhysicsSettings()};
    BodyDef zone;
    zone.kind = BodyKind::kStatic;
    zone.shape = Shape::box(Vec3(3, 3, 3));
    zone.sensor = true;
    ASSERT_TRUE(scene.add(zone).ok());
    const BodyId removed = *scene.add(ball_at(Vec3(1, 0, 0), 1));
    const BodyId carried = *scene.add(ball_at(Vec3(-1, 0, 0), 2));
    scene.step(kFrame);
    ASSERT_EQ(scene.sensor_events().size(), 2U);
    scene.remove(removed);
    BodyState far = scene.state(carried);
    far.position = Vec3(100, 0, 0);
    scene.set_state(carried, far);
    scene.step(kFrame);
    ASSERT_EQ(scene.sensor_events().size(), 2U);
    EXPECT_FALSE(scene.sensor_events()[0].entered);
    EXPECT_EQ(scene.sensor_events()[0].b, removed);
    EXPECT_FALSE(scene.sensor_events()[1].entered);
    EXPECT_EQ(scene.sensor_events()[1].b, carried);
    scene.step(kFrame);
    EXPECT_TRUE(scene.sensor_events().empty());
}

TEST(Sensor, AsAPartOfABodyFeelsWhatTheBodyComesNear) {
    CompoundPart core;
    core.shape = Shape::box(Vec3::Constant(0.5F));
    CompoundPart feeler;
    feeler.shape = Shape::sphere(2.0F);
    feeler.sensor = true;
    const CompoundPart parts[] = {core, feeler};
    const BuiltCompound built = *build_compound(parts);
    EXPECT_FLOAT_EQ(built.mass, 1000.0F);
    PhysicsSettings settings;
    settings.gravity = Vec3::Zero();
    Scene scene(settings);
    BodyDef def;
    def.shape = Shape::compound(built.compound);
    def.velocity = Vec3(2, 0, 0);
    const BodyId body = *scene.add(def);
    BodyDef post;
    post.kind = BodyKind::kStatic;
    post.shape = Shape::sphere(0.5F);
    post.position = Vec3(6, 1.8F, 0);  // meets the feeler, not the core
    ASSERT_TRUE(scene.add(post).ok());
    int entered = 0;
    int left = 0;
    for (int i = 0; i < 360; ++i) {
        scene.step(kFrame);
        for (const SensorEvent& e : scene.sensor_events()) {
            (e.entered ? entered : left) += 1;
        }
    }
    EXPECT_EQ(entered, 1);
    EXPECT_EQ(left, 1);
    EXPECT_NEAR(scene.state(body).position.x(), 12.0F, 1e-3F);
    // Rays do not see sensors.
    RayHit hit;
    const Vec3 x = scene.state(body).position;
    ASSERT_TRUE(scene.ray_cast(x + Vec3(5, 0, 0), Vec3(-1, 0, 0), 10.0F, 0, hit));
    EXPECT_NEAR(hit.distance, 4.5F, 1e-4F);
}

TEST(ContactEvent, TellsPointNormalAndDepth) {
    Scene scene{PhysicsSettings()};
    add_static(scene, mesh_shape(grid_mesh(10, 1.0F, [](float, float) { return 0.0F; })));
    BodyDef def = ball_at(Vec3(0.2F, 0.49F, 0.1F), 5);
    def.user = 5;
    ASSERT_TRUE(scene.add(def).ok());
    scene.step(kFrame);
    ASSERT_EQ(scene.contact_events().size(), 1U);
    const ContactEvent& e = scene.contact_events()[0];
    EXPECT_TRUE(e.began);
    EXPECT_LT((e.point - Vec3(0.2F, 0, 0.1F)).norm(), 0.02F);
    EXPECT_NEAR(std::abs(e.normal.y()), 1.0F, 1e-5F);
    EXPECT_NEAR(e.depth, 0.01F, 1e-4F);
    EXPECT_GT(e.impulse, 0.0F);
}

TEST(WhyUnfit, NamesWhatIsWrong) {
    const auto reason = [](BodyDef def) {
        return why_unfit(def);
    };
    BodyDef def;
    def.shape = Shape::mesh(nullptr);
    EXPECT_EQ(reason(def), "mesh: only for static bodies");
    def.kind = BodyKind::kStatic;
    EXPECT_EQ(reason(def), "mesh: no geometry");
    def.shape.geometry = hull_shape(box_corners(Vec3::Ones())).geometry;
    EXPECT_EQ(reason(def), "mesh: geometry of another kind");
    def.shape = Shape::heightfield(nullptr);
    EXPECT_EQ(reason(def), "heightfield: no geometry");
    def = BodyDef();
    def.shape = Shape::hull(nullptr);
    EXPECT_EQ(reason(def), "hull: no geometry");
    def = BodyDef();
    def.material.density = 0.0F;
    EXPECT_EQ(reason(def), "density out of range");
    def = BodyDef();
    def.material.friction_rule = static_cast<Combine>(77);
    EXPECT_EQ(reason(def), "unknown combine rule");
    def = BodyDef();
    def.moments = Vec3(1, 1, 3);
    EXPECT_EQ(reason(def), "inertia: a moment exceeds the sum of the other two: 1, 1, 3 kg m2");
    def.moments = Vec3(1, -1, 1);
    EXPECT_EQ(reason(def), "inertia: not positive: the principal moments are 1, -1, 1 kg m2");
    def.moments = Vec3(1, std::numeric_limits<float>::quiet_NaN(), 1);
    EXPECT_EQ(reason(def), "inertia: not finite");
    def.moments = Vec3(1, 1, 1);
    EXPECT_EQ(reason(def), "");
}

}  // namespace
}  // namespace zoned::physics
