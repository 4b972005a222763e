// Soft types in configs: the form that the physics gets for each, and where entities are put.
#include "server/config/types/soft_types.h"

#include "server/config/expand/stability_report.h"
#include "server/config/world/scatter.h"
#include "tests/unit/config/config_helpers.h"

#include <algorithm>

namespace zoned::config::test {
namespace {

constexpr float kSoftRounding = 1.0e-5F;  // of floats about a metre, a few operations on

const std::string kForms = R"(
type {
  name: "curtain"
  soft { cloth { width_m: 4 height_m: 2 columns: 9 rows: 5 stiffness_npm: 700
                 pin { column: 0 row: 0 } pin { column: 8 row: 0 } }
         thickness_m: 0.05 drag_ps: 0.5 tear_force_n: 300 }
  mass_kg: 6
  friction: 0.25
}
type {
  name: "rope"
  soft { rope { length_m: 3 nodes: 7 } method: IMPLICIT_EULER substeps: 3 }
  mass_kg: 2
}
type {
  name: "jelly"
  soft { jelly { size { x_m: 1 y_m: 0.5 z_m: 2 } nodes_x: 3 nodes_y: 3 nodes_z: 5 } }
  mass_kg: 10
}
type { name: "balloon" soft { balloon { radius_m: 0.4 splits: 1 } } }
entity { type: "curtain" x_m: -50 y_m: 3 z_m: 0 }
entity { type: "jelly" x_m: 50 z_m: 0 }
)";

const Outcome& forms() {
    static const Outcome out = parse(kValid + kForms);
    EXPECT_EQ(format_errors("test", out.errors), "");
    return out;
}

const world::EntityType& soft_type(const std::string& name) {
    const int index = find_type(forms().settings, name);
    return forms().settings.types[static_cast<std::size_t>(index)];
}

const physics::soft::SoftDef& def_of(const std::string& name) {
    return *forms().settings.softs[soft_type(name).solid];
}

TEST(SoftTypes, WeighWhatTheTypeSaysAboutTheirCentreOfMass) {
    for (const auto& [name, mass] : {std::pair("curtain", 6.0F),
                                     std::pair("rope", 2.0F),
                                     std::pair("jelly", 10.0F),
                                     std::pair("balloon", 1.0F)}) {
        ASSERT_EQ(soft_type(name).shape, world::TypeShape::kSoft) << name;
        float sum = 0.0F;
        Vec3 centre = Vec3::Zero();
        float farthest = 0.0F;
        for (const auto& node : def_of(name).nodes) {
            sum += node.mass;
            centre += node.mass * node.position;
            farthest = std::max(farthest, node.position.norm());
        }
        EXPECT_NEAR(sum, mass, kSoftRounding * mass) << name;
        EXPECT_LT((centre / sum).norm(), kSoftRounding) << name;
        EXPECT_LE(farthest, soft_type(name).extent()) << name;
    }
}

TEST(SoftTypes, AreAsTheConfigDescribesThem) {
    const auto& curtain = def_of("curtain");
    ASSERT_EQ(curtain.nodes.size(), 45u);
    // Upright: column 0, row 0 is at least x, at the top.
    EXPECT_LT((curtain.nodes[0].position - Vec3(-2.0F, 1.0F, 0.0F)).norm(), kSoftRounding);
    EXPECT_TRUE(curtain.nodes[0].pinned);
    EXPECT_EQ(
        std::count_if(
            curtain.nodes.begin(), curtain.nodes.end(), [](const auto& n) { return n.pinned; }),
        2);
    EXPECT_EQ(curtain.springs[0].stiffness, 700.0F);
    EXPECT_EQ(curtain.material.thickness, 0.05F);
    EXPECT_EQ(curtain.material.drag, 0.5F);
    EXPECT_EQ(curtain.material.tear_force, 300.0F);
    EXPECT_EQ(curtain.material.friction, 0.25F);
    const auto& rope = def_of("rope");
    EXPECT_LT((rope.nodes.front().position - Vec3(0.0F, 1.5F, 0.0F)).norm(), kSoftRounding);
    EXPECT_LT((rope.nodes.back().position - Vec3(0.0F, -1.5F, 0.0F)).norm(), kSoftRounding);
    EXPECT_EQ(rope.solver.method, physics::soft::SoftMethod::kImplicitEuler);
    EXPECT_EQ(rope.solver.substeps, 3);
    EXPECT_EQ(def_of("jelly").nodes.size(), 45u);
    EXPECT_EQ(def_of("balloon").nodes.size(), 42u);
    EXPECT_GT(def_of("balloon").material.gas_pressure, def_of("balloon").material.ambient_pressure);
}

TEST(SoftTypes, StandWithTheirThicknessAboveTheGround) {
    for (const InitialEntity& entity : forms().settings.initial) {
        if (entity.type == find_type(forms().settings, "jelly")) {
            // 0.25 m of jelly below the centre, 0.02 m of thickness, at most 2 cm of clearance.
            EXPECT_GE(entity.position.y(), 0.27);
            EXPECT_LE(entity.position.y(), 0.29);
        } else if (entity.type == find_type(forms().settings, "curtain")) {
            EXPECT_NEAR(entity.position.y(), 3.0, 1e-6);
        }
    }
}

TEST(SoftTypes, AreNoneOfTheRigidSolvers) {
    for (const std::string& warning : stability_warnings_of(forms().settings)) {
        EXPECT_EQ(warning.find("balloon"), std::string::npos) << warning;
    }
}

}  // namespace
}  // namespace zoned::config::test
