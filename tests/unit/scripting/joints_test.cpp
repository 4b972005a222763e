// Joints that a script makes, and rays at the world that a client displayed.
#include "tests/unit/scripting/script_zone.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>

namespace zoned::scripting::test {
namespace {

using physics::JointKind;
using ::testing::HasSubstr;

/// The plan of the only joint that a call makes between two crates.
zone::JointPlan plan_of(const std::string& arguments) {
    ScriptZone zone(
        "function on_tick() local a, b = spawn('crate', 0, 0, 0), spawn('crate', 2, 0, 0) "
        "print(add_joint(a, b, " +
        arguments + ")) end");
    zone.tick();
    EXPECT_EQ(zone.errors(), "") << arguments;
    EXPECT_EQ(zone.printed(), "1") << arguments;
    EXPECT_EQ(zone.joints.size(), 1u) << arguments;
    return zone.joints.empty() ? zone::JointPlan() : zone.joints[0].plan;
}

/// The error of a call with these options.
std::string joint_error(const std::string& arguments) {
    return error_of("add_joint(nil, spawn('crate', 0, 0, 0), " + arguments + ")");
}

TEST(ScriptJoints, AreOfEachKind) {
    const physics::JointDef plain;
    for (const auto& [name, kind] : {std::pair("ball", JointKind::kBall),
                                     std::pair("hinge", JointKind::kHinge),
                                     std::pair("slider", JointKind::kSlider),
                                     std::pair("fixed", JointKind::kFixed),
                                     std::pair("distance", JointKind::kDistance),
                                     std::pair("spring", JointKind::kSpring)}) {
        const zone::JointPlan plan = plan_of("'" + std::string(name) + "'");
        EXPECT_EQ(plan.def.kind, kind);
        EXPECT_EQ(plan.def.axis, plain.axis);
        EXPECT_EQ(plan.def.length_m, plain.length_m);
        EXPECT_EQ(plan.def.break_force_n, plain.break_force_n);
        EXPECT_FALSE(plan.def.limited || plan.def.motor || plan.motor || plan.def.collide);
    }
}

TEST(ScriptJoints, TakeTheParametersOfTheirKind) {
    const zone::JointPlan hinge = plan_of(
        "'hinge', { name = 'door', anchor = { 1, 2, 3 }, axis = { 0, 0, 2 }, lower = -1, upper = "
        "0.5, collide = true, break_force_n = 900, motor = { position = 0.25, most = 40, "
        "max_speed = 3 } }");
    EXPECT_EQ(hinge.name, "door");
    EXPECT_EQ(hinge.def.anchor, Vec3(1.0F, 2.0F, 3.0F));
    EXPECT_EQ(hinge.def.axis, Vec3(0.0F, 0.0F, 2.0F));
    EXPECT_TRUE(hinge.def.limited && hinge.def.collide);
    EXPECT_EQ(hinge.def.lower, -1.0F);
    EXPECT_EQ(hinge.def.upper, 0.5F);
    EXPECT_EQ(hinge.def.break_force_n, 900.0F);
    EXPECT_FALSE(hinge.def.motor);
    ASSERT_TRUE(hinge.motor);
    EXPECT_TRUE(hinge.motor->holds_position);
    EXPECT_EQ(hinge.motor->target.mean, 0.25F);
    EXPECT_EQ(hinge.motor->most, 40.0F);
    EXPECT_EQ(hinge.motor->max_speed, 3.0F);

    const zone::JointPlan slider = plan_of("'slider', { motor = { speed = -2, most = 7 } }");
    ASSERT_TRUE(slider.motor);
    EXPECT_FALSE(slider.motor->holds_position);
    EXPECT_EQ(slider.motor->target.mean, -2.0F);

    const zone::JointPlan ball =
        plan_of("'ball', { cone_axis = { 0, 1, 0 }, cone_rad = 0.5, friction = 2 }");
    EXPECT_EQ(ball.def.cone_axis, Vec3::UnitY());
    EXPECT_EQ(ball.def.cone_rad, 0.5F);
    EXPECT_TRUE(ball.def.motor);
    EXPECT_EQ(ball.def.motor_max, 2.0F);

    const zone::JointPlan spring = plan_of(
        "'spring', { anchor = { 1, 0, 0 }, anchor_b = { 0, 1, 0 }, length_m = 3, spring_hz = 4, "
        "spring_damping_ratio = 0.75 }");
    EXPECT_EQ(spring.def.anchor, Vec3::UnitX());
    EXPECT_EQ(spring.def.anchor_b, Vec3::UnitY());
    EXPECT_EQ(spring.def.length_m, 3.0F);
    EXPECT_EQ(spring.def.spring_hz, 4.0F);
    EXPECT_EQ(spring.def.spring_damping_ratio, 0.75F);
}

TEST(ScriptJoints, AreNotMadeWithWhatIsNotOfThisZone) {
    ScriptZone zone(R"(function on_tick()
        local a = spawn('crate', 0, 0, 0)
        print(add_joint(a, 999, 'fixed'), add_joint(999, a, 'fixed'), add_joint(a, nil, 'fixed'),
              add_joint(nil, a, 'fixed'))
    end)");
    zone.tick();
    EXPECT_EQ(zone.errors(), "");
    EXPECT_EQ(zone.printed(), "nil nil nil 1");
    ASSERT_EQ(zone.joints.size(), 1u);
    EXPECT_FALSE(zone.joints[0].a);
}

TEST(ScriptJoints, SayWhatIsWrongWithThem) {
    struct WrongJoint {
        const char* arguments;
        const char* error;
    };

    for (const WrongJoint& wrong : {
             WrongJoint{"'rope'", "#3 to 'add_joint' (kind: ball, hinge, slider"},
             WrongJoint{"'fixed', 1", "#4 to 'add_joint' (table expected"},
             WrongJoint{"'fixed', { axis = { 0, 1, 0 } }", "it has no setting 'axis'"},
             WrongJoint{"'distance', { motor = {} }", "it has no setting 'motor'"},
             WrongJoint{"'hinge', { axis = { 0, 0, 0 } }", "joint: axis has no direction"},
             WrongJoint{"'hinge', { axis = { 0, 1 } }", "axis: a number is wanted, not nil"},
             WrongJoint{"'hinge', { anchor = { 1/0, 0, 0 } }", "anchor: a finite number"},
             WrongJoint{"'hinge', { lower = 1 }", "lower and upper: give both, or none"},
             WrongJoint{"'hinge', { lower = 2, upper = 1 }", "lower limit above the upper one"},
             WrongJoint{"'hinge', { friction = 1, motor = { speed = 1, most = 1 } }",
                        "either friction or a motor"},
             WrongJoint{"'hinge', { motor = { most = 1 } }", "either speed or position"},
             WrongJoint{"'hinge', { motor = { speed = 1 } }", "most must be above 0"},
             WrongJoint{"'hinge', { motor = { position = 1, most = 1 } }",
                        "max_speed must be above 0"},
             WrongJoint{"'slider', { lower = 0, upper = 1, "
                        "motor = { position = 2, most = 1, max_speed = 1 } }",
                        "its position is outside the limits"},
             WrongJoint{"'ball', { cone_rad = 4 }", "joint: cone out of range"},
             WrongJoint{"'spring', { spring_hz = -1 }", "spring frequency or damping"},
             WrongJoint{"'fixed', { break_force_n = 0 }", "must be positive"},
         }) {
        EXPECT_THAT(joint_error(wrong.arguments), HasSubstr(wrong.error)) << wrong.arguments;
    }
}

TEST(ScriptRays, SayHowTheyWereJudged) {
    ScriptZone zone(R"(function on_tick()
        local ball = spawn('ball', 5, 0, 0)
        local seen = { tick = 90, aimed = ball,
                       entities = { { entity = ball, x = 5, y = 1, z = 2, publication = 88 } } }
        for _, dx in ipairs({ 1, -1 }) do
            local d, hit, x, y, z, nx, ny, nz, how = ray_cast_as_seen(3, seen, 0, 0, 0, dx, 0, 0, 50)
            print(d, hit == ball, x, nx, how.rewound_s, how.cut, how.doubted, how.aimed_near)
        end
    end)");
    zone.as_seen.rewound_s = 0.125F;
    zone.as_seen.doubted = true;
    zone.as_seen.aimed_near = true;
    zone.tick();
    EXPECT_EQ(zone.errors(), "");
    EXPECT_EQ(zone.printed(),
              "5.0 true 5.0 -1.0 0.125 false true true|nil false nil nil 0.125 false true true");
    ASSERT_EQ(zone.claims.size(), 1u);
    EXPECT_EQ(zone.claims[0].position, Vec3(5.0F, 1.0F, 2.0F));
    EXPECT_EQ(zone.claims[0].publication, 88);
    zone.clear();
    zone.as_seen = {};
    zone.as_seen.cut = true;
    zone.tick();
    EXPECT_THAT(zone.printed(), HasSubstr("0.0 true false false"));
}

TEST(ScriptRays, TakeFewClaims) {
    EXPECT_THAT(error_of("local all = {} for i = 1, 9 do all[i] = { entity = 1, x = 0, y = 0, z = "
                         "0 } end ray_cast_as_seen(1, { tick = 1, entities = all }, 0, 0, 0, 1, "
                         "0, 0, 5)"),
                HasSubstr("entities: at most 8 are wanted"));
}

}  // namespace
}  // namespace zoned::scripting::test
