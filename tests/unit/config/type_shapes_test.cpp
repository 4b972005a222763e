// Hulls and compounds in configs: their shapes, how they stand, and where they are put.
#include "server/config/types/type_shapes.h"

#include "server/config/settings.h"
#include "server/config/world/scatter.h"
#include "server/physics/scene/scene.h"
#include "server/zone/simulation/type_body.h"
#include "tests/unit/config/config_helpers.h"

#include <cmath>

namespace zoned::config::test {
namespace {

constexpr float kRounding = 1.0e-5F;  // of floats about a metre, a few operations on

/// A wedge, 2 m wide, 1 m high, 3 m long, far from its points' origin. A table of two kinds of
/// matter: a top 0.1 m thick at 1 m of density 1, and a foot of density 3.
const std::string kShapes = R"(
type {
  name: "wedge"
  hull {
    point { x_m: 10 y_m: 5 z_m: 0 } point { x_m: 12 y_m: 5 z_m: 0 }
    point { x_m: 10 y_m: 5 z_m: 3 } point { x_m: 12 y_m: 5 z_m: 3 }
    point { x_m: 10 y_m: 6 z_m: 0 } point { x_m: 12 y_m: 6 z_m: 0 }
  }
  mass_kg: 7
  friction: 0.25
}
type {
  name: "table"
  compound {
    part { box { x_m: 2 y_m: 0.1 z_m: 1 } y_m: 1.05 density_kgpm3: 1 }
    part { box { x_m: 0.5 y_m: 1 z_m: 0.2 } y_m: 0.5 density_kgpm3: 3 }
  }
  mass_kg: 50
}
entity { type: "wedge" x_m: -50 z_m: 0 yaw_deg: 0 }
entity { type: "table" x_m: 50 z_m: 0 yaw_deg: 90 }
)";

const Outcome& world() {
    static const Outcome out = parse(kValid + kShapes);
    EXPECT_EQ(format_errors("test", out.errors), "");
    return out;
}

const world::EntityType& type_of(const std::string& name) {
    const int index = find_type(world().settings, name);
    return world().settings.types[static_cast<std::size_t>(index)];
}

const InitialEntity& first_of(const std::string& name) {
    const int index = find_type(world().settings, name);
    for (const InitialEntity& entity : world().settings.initial) {
        if (entity.type == index) {
            return entity;
        }
    }
    ADD_FAILURE() << name;
    return world().settings.initial.front();
}

TEST(TypeShapes, GiveAHullItsCentreOfMass) {
    // A wedge's section is a triangle: its centre lies a third of the length from the right angle.
    const world::EntityType& wedge = type_of("wedge");
    EXPECT_EQ(wedge.shape, world::TypeShape::kSolid);
    EXPECT_TRUE(wedge.standing.lower.isApprox(Vec3(-1.0F, -1.0F / 3.0F, -1.0F), kRounding));
    EXPECT_TRUE(wedge.standing.upper.isApprox(Vec3(1.0F, 2.0F / 3.0F, 2.0F), kRounding));
    EXPECT_NEAR(wedge.extent(), std::sqrt(1.0F + 1.0F / 9.0F + 4.0F), kRounding);
}

TEST(TypeShapes, WeighPartsByTheirDensity) {
    // 0.2 m3 of 1 at 1.05 m and 0.1 m3 of 3 at 0.5 m.
    const float centre = (0.2F * 1.05F + 0.3F * 0.5F) / 0.5F;
    const world::EntityType& table = type_of("table");
    EXPECT_NEAR(table.standing.lower.y(), -centre, kRounding);
    EXPECT_NEAR(table.standing.upper.y(), 1.1F - centre, kRounding);
    EXPECT_NEAR(table.standing.upper.x(), 1.0F, kRounding);
    EXPECT_NEAR(table.standing.upper.z(), 0.5F, kRounding);
}

TEST(TypeShapes, BecomeBodiesOfTheTypesMassAndFriction) {
    const physics::BodyDef def = zone::body_of(type_of("wedge"), world().settings.solids);
    EXPECT_EQ(def.shape.kind, physics::ShapeKind::kHull);
    EXPECT_EQ(def.mass, 7.0F);
    EXPECT_EQ(def.material.friction, 0.25F);
    EXPECT_EQ(zone::body_of(type_of("table"), world().settings.solids).shape.kind,
              physics::ShapeKind::kCompound);
}

TEST(TypeShapes, AreTurnedAsWrittenAndStandOnWhatIsBelow) {
    const InitialEntity& wedge = first_of("wedge");
    EXPECT_LT(wedge.orientation.angularDistance(type_of("wedge").stands), kRounding);
    EXPECT_NEAR(wedge.position.y(), 1.0 / 3.0, 0.01);
    const InitialEntity& table = first_of("table");
    const Quat quarter(Eigen::AngleAxisf(0.5F * std::acos(-1.0F), Vec3::UnitY()));
    EXPECT_LT(table.orientation.angularDistance(quarter * type_of("table").stands), 1.0e-3F);
}

/// An entity that stood as written stays so: the foot carries the top, the wedge lies on its base.
TEST(TypeShapes, StayAsTheyStand) {
    physics::PhysicsSettings settings = world().settings.physics;
    physics::Scene scene(settings);
    physics::BodyDef ground;
    ground.kind = physics::BodyKind::kStatic;
    ground.shape = physics::Shape::plane();
    ASSERT_TRUE(scene.add(ground).ok());
    std::vector<std::pair<physics::BodyDef, BodyId>> bodies;
    for (const std::string name : {"wedge", "table"}) {
        physics::BodyDef def = zone::body_of(type_of(name), world().settings.solids);
        def.position = first_of(name).position.cast<float>();
        def.orientation = first_of(name).orientation;
        bodies.emplace_back(def, *scene.add(def));
    }
    for (int i = 0; i < 60; ++i) {
        scene.step(1.0F / 30.0F);
    }
    for (const auto& [def, id] : bodies) {
        const physics::BodyState state = scene.state(id);
        EXPECT_LT((state.position - def.position).norm(), settings.error_budget_m);
        EXPECT_LT(state.orientation.angularDistance(def.orientation), 0.01F);
    }
}

/// kValid's crate, or another type, with a tensor.
Outcome with_inertia(const std::string& type, const std::string& inertia) {
    std::string text = kValid + kShapes;
    const std::string line = "name: \"" + type + "\"\n";
    return parse(
        text.replace(text.find(line), line.size(), line + "inertia { " + inertia + " }\n"));
}

TEST(GivenInertia, IsAlongTheAxesInWhichTheShapeIsWrittenDown) {
    Mat3 given;
    given << 3.0F, 0.5F, -0.2F,  //
        0.5F, 4.0F, 0.1F,        //
        -0.2F, 0.1F, 5.0F;
    for (const std::string name : {"crate", "wedge", "table"}) {
        const Outcome out = with_inertia(name,
                                         "xx_kg_m2: 3 yy_kg_m2: 4 zz_kg_m2: 5 xy_kg_m2: 0.5 "
                                         "xz_kg_m2: -0.2 yz_kg_m2: 0.1");
        ASSERT_TRUE(out.ok) << format_errors("test", out.errors);
        const auto index = static_cast<std::size_t>(find_type(out.settings, name));
        const world::EntityType& type = out.settings.types[index];
        const Mat3 turn = type.stands.toRotationMatrix();
        const Mat3 body = zone::body_of(type, out.settings.solids).inertia;
        EXPECT_TRUE((turn * body * turn.transpose()).isApprox(given, kRounding)) << name;
        EXPECT_EQ(body, body.transpose()) << name << ": a scene refuses any other";
    }
    EXPECT_TRUE(type_of("wedge").inertia.isZero()) << "that of the shape where none is given";
}

TEST(GivenInertia, IsCheckedWithItsPlace) {
    const auto errors = [](const std::string& type, const std::string& inertia) {
        return format_errors("test", with_inertia(type, inertia).errors);
    };
    const std::string good = "xx_kg_m2: 1 yy_kg_m2: 1 zz_kg_m2: 1";
    EXPECT_NE(errors("crate", "xx_kg_m2: 1 yy_kg_m2: 2 zz_kg_m2: 3.5").find("sum of the other two"),
              std::string::npos);
    EXPECT_NE(errors("crate", good + " xy_kg_m2: 2").find("not positive"), std::string::npos);
    EXPECT_NE(errors("crate", "xx_kg_m2: 1 yy_kg_m2: 1").find("not positive"), std::string::npos);
    EXPECT_NE(errors("crate", "").find("needs xx_kg_m2"), std::string::npos);
    EXPECT_NE(errors("player", good).find("rigid props only"), std::string::npos);
    EXPECT_NE(errors("crate", "").find("inertia"), std::string::npos);
    EXPECT_EQ(errors("crate", good), "");
}

}  // namespace
}  // namespace zoned::config::test
