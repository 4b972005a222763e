// Types of several bodies and joints: what they are expanded to, and the reported mistakes.
#include "tests/unit/config/config_helpers.h"

#include <gtest/gtest.h>

#include <numbers>
#include <utility>

namespace zoned::config::test {
namespace {

constexpr float kPi = std::numbers::pi_v<float>;

const std::string kCart = R"(type {
  name: "cart" friction: 0.9
  aura_m { normal: 40 }
  assembly {
    part { name: "bed" box { x_m: 1 y_m: 0.2 z_m: 2 } y_m: 0.5 mass_kg: 50 }
    part { name: "left" sphere { radius_m: 0.25 } x_m: 0.5 y_m: 0.25 mass_kg: 4 friction: 1.5 }
    part { name: "hub" box { x_m: 0.1 y_m: 0.1 z_m: 0.1 } x_m: -0.5 y_m: 0.25 mass_kg: 2 replicated: false }
    joint { name: "axle" a: "bed" b: "left" hinge { axis { x: 2 } motor { speed_rps { constant: 0 } max_torque_nm: 30 } } }
    joint { a: "bed" b: "hub" anchor { y_m: 0.05 } slider { min_m: -0.1 max_m: 0.2 friction_n: 7 } break_force_n: 900 }
    seat { place { y_m: 1 } }
    control { joint: "axle" value: 12 }
  }
}
)";

TEST(Assemblies, BecomeATypeForEachPart) {
    const Outcome out = parse(kValid + kCart);
    ASSERT_TRUE(out.ok) << format_errors("test", out.errors);
    const world::TypeTable& types = out.settings.types;
    ASSERT_EQ(types.size(), 6U);
    EXPECT_EQ(types[3].name, "cart");
    EXPECT_EQ(types[4].name, "cart.left");
    EXPECT_EQ(types[5].name, "cart.hub");
    EXPECT_TRUE(types[3].is_root());
    EXPECT_EQ(types[4].assembly, types[3].assembly);
    EXPECT_EQ(types[5].part, 2);
    EXPECT_EQ(types[3].mass, 50.0F);
    EXPECT_EQ(types[4].mass, 4.0F);
    EXPECT_EQ(types[3].friction, 0.9F);
    EXPECT_EQ(types[4].friction, 1.5F);
    EXPECT_EQ(types[4].aura_m[0], 40.0F);
    EXPECT_EQ(types[5].aura_m[0], 0.0F) << "nobody needs to hear of it";
    // The whole about the root's centre, 0.5 m up.
    EXPECT_NEAR(types[3].standing.lower.y(), -0.5F, 1e-6F);
    EXPECT_NEAR(types[3].standing.upper.x(), 0.75F, 1e-6F);
}

TEST(Assemblies, KeepPosesJointsSeatsAndControls) {
    const Outcome out = parse(kValid + kCart);
    ASSERT_TRUE(out.ok) << format_errors("test", out.errors);
    ASSERT_EQ(out.settings.assemblies->size(), 1U);
    const zone::AssemblyDef& cart = out.settings.assemblies->front();
    ASSERT_EQ(cart.parts.size(), 3U);
    EXPECT_TRUE(cart.parts[1].position.isApprox(Vec3(0.5F, -0.25F, 0.0F)));
    ASSERT_EQ(cart.joints.size(), 2U);
    const zone::JointPlan& axle = *cart.joints[0].plan;
    EXPECT_EQ(axle.def.kind, physics::JointKind::kHinge);
    EXPECT_TRUE(axle.def.axis.isApprox(Vec3::UnitX()));
    ASSERT_TRUE(axle.motor);
    EXPECT_FALSE(axle.motor->holds_position);
    EXPECT_EQ(axle.motor->most, 30.0F);
    const zone::JointPlan& slider = *cart.joints[1].plan;
    EXPECT_TRUE(slider.def.limited);
    EXPECT_EQ(slider.def.upper, 0.2F);
    EXPECT_EQ(slider.def.break_force_n, 900.0F);
    EXPECT_TRUE(slider.def.motor) << "friction is a motor that wants to stand still";
    EXPECT_EQ(slider.def.motor_max, 7.0F);
    EXPECT_EQ(slider.def.anchor, Vec3(0.0F, 0.05F, 0.0F));
    ASSERT_EQ(cart.seats.size(), 1U);
    EXPECT_EQ(cart.seats[0].part, 0);
    ASSERT_EQ(cart.controls.size(), 1U);
    EXPECT_EQ(cart.controls[0].value, 12.0F);
    EXPECT_FALSE(cart.controls[0].sideways);
}

TEST(Assemblies, GiveBallJointsFriction) {
    std::string text = kValid + kCart;
    const std::string slider = "slider { min_m: -0.1 max_m: 0.2 friction_n: 7 }";
    text.replace(text.find(slider), slider.size(), "ball { friction_nm: 2.5 }");
    const Outcome out = parse(text);
    ASSERT_TRUE(out.ok) << format_errors("test", out.errors);
    const physics::JointDef& def = out.settings.assemblies->front().joints[1].plan->def;
    EXPECT_EQ(def.kind, physics::JointKind::kBall);
    EXPECT_TRUE(def.motor);
    EXPECT_EQ(def.motor_max, 2.5F);
}

std::string with_ball(const std::string& ball) {
    return with(
        "slider { min_m: -0.1 max_m: 0.2 friction_n: 7 }", "ball { " + ball + " }", kValid + kCart);
}

TEST(Assemblies, GiveBallJointsConeAndTwist) {
    const Outcome out =
        parse(with_ball("axis { y: -2 } cone_axis { x: 1 y: -1 } cone_deg: 60 twist_min_deg: -30 "
                        "twist_max_deg: 90"));
    ASSERT_TRUE(out.ok) << format_errors("test", out.errors);
    const physics::JointDef& def = out.settings.assemblies->front().joints[1].plan->def;
    EXPECT_TRUE(def.axis.isApprox(-Vec3::UnitY()));
    EXPECT_TRUE(def.cone_axis.isApprox(Vec3(1, -1, 0).normalized()));
    EXPECT_NEAR(def.cone_rad, kPi / 3.0F, 1e-6F);
    EXPECT_TRUE(def.limited);
    EXPECT_NEAR(def.lower, -kPi / 6.0F, 1e-6F);
    EXPECT_NEAR(def.upper, kPi / 2.0F, 1e-6F);
    EXPECT_FALSE(def.motor);
}

TEST(Assemblies, RefuseConesAndTwistsThatMakeNoSense) {
    const std::pair<const char*, const char*> mistakes[] = {
        {"twist_min_deg: -30 twist_max_deg: 30", "goes with cone_deg"},
        {"cone_axis { x: 1 }", "goes with cone_deg"},
        {"cone_deg: 40 cone_axis { x: 1 }", "90 degrees from it, outside cone_deg, 40"},
        {"cone_deg: 40 cone_axis { }", "needs a direction"},
        {"cone_deg: 40 twist_min_deg: 5", "goes with twist_max_deg"},
        {"cone_deg: 40 twist_min_deg: 9 twist_max_deg: 5", "9 is above twist_max_deg, 5"},
        {"cone_deg: 170 twist_min_deg: -9 twist_max_deg: 5", "within a cone of at most 150"},
        {"cone_deg: 0.5", "out of range"},
    };
    for (const auto& [ball, words] : mistakes) {
        const Outcome out = parse(with_ball(ball));
        EXPECT_FALSE(out.ok) << ball;
        EXPECT_NE(format_errors("test", out.errors).find(words), std::string::npos)
            << ball << ": " << format_errors("test", out.errors);
    }
}

TEST(Assemblies, StandOnTheirLowestPart) {
    const Outcome out =
        parse(kValid + kCart + "entity { type: \"cart\" x_m: 10 z_m: 3 yaw_deg: 90 }\n");
    ASSERT_TRUE(out.ok) << format_errors("test", out.errors);
    ASSERT_EQ(out.settings.initial.size(), 1U);
    EXPECT_NEAR(out.settings.initial[0].position.y(), 0.5, 0.005);
    // Turned by a quarter about y, z points along x.
    EXPECT_NEAR((out.settings.initial[0].orientation * Vec3::UnitZ()).x(), 1.0F, 1e-4F);
}

TEST(Assemblies, OfABaseAreTakenOver) {
    const Outcome out =
        parse(kValid + kCart + "type { name: \"red\" base: \"cart\" priority: 2 }\n");
    ASSERT_TRUE(out.ok) << format_errors("test", out.errors);
    ASSERT_EQ(out.settings.assemblies->size(), 2U);
    EXPECT_EQ(out.settings.types.back().name, "red.hub");
    EXPECT_EQ(out.settings.types.back().priority, 2.0F);
}

struct Mistake {
    const char* from;
    const char* to;
    const char* needle;
    const char* words;
};

TEST(Assemblies, AreRefusedWhereTheyMakeNoSense) {
    const std::string text = kValid + kCart;
    const Mistake mistakes[] = {
        {"z_m: 0.1 } x_m: -0.5",
         "z_m: 0.1 } x_m: 0.4",
         "part { name: \"hub\"",
         "overlaps part 'left' by"},
        {"b: \"left\" hinge", "b: \"lft\" hinge", "b: \"lft\"", "no part named 'lft'"},
        {"b: \"left\" hinge", "b: \"bed\" hinge", "b: \"bed\"", "joined to itself"},
        {"name: \"left\" sphere { radius_m: 0.25 }",
         "name: \"left\"",
         "part { name: \"left\"",
         "needs a shape"},
        {"name: \"hub\"", "name: \"left\"", "name: \"left\" box", "name of another part"},
        {"axis { x: 2 }", "axis { }", "axis { }", "needs a direction"},
        {"min_m: -0.1 max_m: 0.2",
         "min_m: 0.3 max_m: 0.2",
         "min_m: 0.3",
         "0.3 is above max_m, 0.2"},
        {"min_m: -0.1 max_m", "max_m", "slider {", "goes with max_m"},
        {"max_torque_nm: 30", "", "motor {", "above 0"},
        {"speed_rps { constant: 0 } ", "", "motor {", "needs speed_rps or angle_deg"},
        {"speed_rps { constant: 0 } ", "speed_rps { } ", "speed_rps { }", "needs constant, sine"},
        {"joint: \"axle\"", "joint: \"axel\"", "joint: \"axel\"", "no joint named 'axel'"},
        {"friction: 0.9\n", "mass_kg: 5\n", "mass_kg: 5\n", "each part of an assembly has its own"},
        {"friction: 0.9\n", "kind: CHARACTER\n", "assembly {", "belongs to props only"},
    };
    for (const Mistake& m : mistakes) {
        expect_single(with(m.from, m.to, text), m.needle, m.words);
    }
    const std::string loose = with(
        "joint { a: \"bed\" b: \"hub\" anchor { y_m: 0.05 } slider { min_m: -0.1 max_m: 0.2 "
        "friction_n: 7 } break_force_n: 900 }",
        "",
        text);
    expect_single(loose, "part { name: \"hub\"", "no joint holds it");
    // The type was made from the part: the mistake is where the part is written.
    expect_single(
        with("sphere { radius_m: 0.25 }",
             "hull { point { } point { x_m: 1 } point { y_m: 1 } point { x_m: 1 y_m: 1 } }",
             text),
        "hull {",
        "type 'cart.left'");
}

TEST(Motors, FollowTimeAsWritten) {
    const std::string ramps =
        "angle_deg { ramps { point { at_s: 1 value: 90 } point { at_s: 3 value: -90 } period_s: 4 "
        "} }";
    const Outcome out = parse(
        with("speed_rps { constant: 0 }", ramps, kValid + with("value: 12", "value: 30", kCart)));
    ASSERT_TRUE(out.ok) << format_errors("test", out.errors);
    const zone::AssemblyDef& cart = out.settings.assemblies->front();
    const zone::MotorTarget& target = cart.joints[0].plan->motor->target;
    EXPECT_TRUE(cart.joints[0].plan->motor->holds_position);
    EXPECT_NEAR(target.at(0.5), kPi / 2.0F, 1e-6F);
    EXPECT_NEAR(target.at(2.0), 0.0F, 1e-6F);
    EXPECT_NEAR(target.at(3.5), -kPi / 2.0F, 1e-6F);
    EXPECT_NEAR(target.at(6.5), target.at(2.5), 1e-6F) << "it repeats";
    EXPECT_TRUE(target.changes_after(100.0));
    EXPECT_NEAR(cart.controls[0].value, kPi / 6.0F, 1e-6F) << "in the unit of the target";
    expect_single(with("at_s: 3 value",
                       "at_s: 1 value",
                       with("speed_rps { constant: 0 }", ramps, kValid + kCart)),
                  "point { at_s: 1 value: -90",
                  "not after the point before");
    expect_single(
        with(
            "period_s: 4", "period_s: 2", with("speed_rps { constant: 0 }", ramps, kValid + kCart)),
        "point { at_s: 3",
        "beyond the period");
}

const std::string kGate = R"(entity { name: "post" type: "crate" x_m: 20 z_m: 0 }
entity { name: "my.cart" type: "cart" x_m: 30 z_m: 0 }
joint { name: "rope" a: "post" b: "my.cart.left" anchor_a { y_m: 0.5 } spring { frequency_hz: 3 length_m: 9 } }
joint { b: "post" anchor { y_m: -0.5 } fixed { } break_force_n: 5000 }
)";

TEST(PlacedJoints, FindEntitiesAndTheirPartsByName) {
    const Outcome out = parse(kValid + kCart + kGate);
    ASSERT_TRUE(out.ok) << format_errors("test", out.errors);
    ASSERT_EQ(out.settings.placed_joints.size(), 2U);
    const PlacedJoint& rope = out.settings.placed_joints[0];
    EXPECT_EQ(rope.a.entity, 0);
    EXPECT_EQ(rope.b.entity, 1);
    EXPECT_EQ(rope.b.part, 1);
    EXPECT_EQ(rope.plan->def.anchor, Vec3(0.0F, 0.5F, 0.0F));
    EXPECT_EQ(rope.plan->def.length_m, 9.0F);
    EXPECT_EQ(out.settings.placed_joints[1].a.entity, -1);
}

TEST(PlacedJoints, AreRefusedWhereTheyMakeNoSense) {
    const std::string text = kValid + kCart + kGate;
    expect_single(
        with("a: \"post\" b", "a: \"pst\" b", text), "a: \"pst\"", "no placed entity named 'pst'");
    expect_single(with("my.cart.left", "my.cart.wing", text),
                  "b: \"my.cart.wing\"",
                  "has no part named 'wing'");
    expect_single(with("name: \"my.cart\"",
                       "name: \"post\"",
                       with("b: \"my.cart.left\"", "b: \"post.left\"", text)),
                  "name: \"post\" type: \"cart\"",
                  "name of another entity");
    expect_single(
        with("x_m: 20 z_m: 0",
             "x_m: 20 z_m: 0 asleep: true",
             with("joint { b: \"post\" anchor { y_m: -0.5 } fixed { } break_force_n: 5000 }",
                  "",
                  text)),
        "a: \"post\"",
        "begins awake");
    expect_single(with("fixed { }", "", text), "joint { b: \"post\"", "needs a kind");
    expect_single(with("fixed { }", "fixed { } anchor_a { }", text),
                  "anchor_a { }",
                  "distance and spring only");
}

}  // namespace
}  // namespace zoned::config::test
