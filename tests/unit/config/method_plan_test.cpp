// Error budgets in configs: chosen methods, refusals and their words, and the output of explain.
#include "server/config/expand/method_plan.h"

#include "server/config/types/soft_types.h"
#include "server/physics/method_selection/cost_table.h"
#include "server/zone/simulation/type_body.h"
#include "tests/unit/config/config_helpers.h"

#include <algorithm>
#include <cmath>
#include <tuple>

namespace zoned::config::test {
namespace {

using physics::IntegratorKind;
using physics::soft::SoftMethod;

const std::string kSheet = R"(type {
  name: "sheet"
  soft {
    cloth { width_m: 2 height_m: 2 columns: 9 rows: 9 stiffness_npm: 500 shear_stiffness_npm: 250 bend_stiffness_npm: 10
            pin { column: 0 row: 0 } pin { column: 8 row: 0 } level: true }
  }
  mass_kg: 1
  max_acceleration_mps2: 60
}
)";

/// A crate that flies like a feather.
std::string with_drag(const std::string& drag) {
    return with("  box { x_m: 1 y_m: 1 z_m: 1 }\n",
                "  box { x_m: 1 y_m: 1 z_m: 1 }\n  drag_ps: " + drag + "\n");
}

const MethodPlan& plan_of(const Outcome& out, const std::string& subject) {
    for (const MethodPlan& plan : out.settings.methods) {
        if (plan.subject == subject) {
            return plan;
        }
    }
    ADD_FAILURE() << "no plan of " << subject;
    return out.settings.methods.front();
}

TEST(ErrorBudget, UnsetLeavesEverythingAsItWas) {
    const Outcome out = parse(kValid + kSheet);
    ASSERT_TRUE(out.ok) << format_errors("test", out.errors);
    EXPECT_EQ(out.settings.physics.body_integrator, IntegratorKind::kDefault);
    EXPECT_EQ(out.settings.physics.body_flight_pieces, 1);
    EXPECT_EQ(out.settings.physics.particle_flight_pieces, 1);
    EXPECT_EQ(out.settings.softs[0]->solver.method, SoftMethod::kXpbd);
    EXPECT_EQ(out.settings.softs[0]->solver.substeps, 0);
    const std::string text = methods_text(out.settings);
    EXPECT_NE(text.find("bodies: default x 1, the default; no budget (budget.free_flight_m)"),
              std::string::npos)
        << text;
    // The root of 81 nodes.
    EXPECT_NE(text.find("soft type sheet: xpbd x 9, the default; no budget"), std::string::npos)
        << text;
    EXPECT_NE(text.find("props as points: nothing to choose: no type is ever a point"),
              std::string::npos)
        << text;
}

TEST(ErrorBudget, HasNothingToChooseWhereThereIsNothing) {
    const std::string text =
        methods_text(parse(kValid + "budget { soft_share: 0.01 particles_m: 0.1 }\n").settings);
    EXPECT_NE(text.find("soft bodies: nothing to choose: no soft type"), std::string::npos) << text;
    EXPECT_NE(text.find("props as points: nothing to choose"), std::string::npos) << text;
}

TEST(ErrorBudget, ReachesBodiesParticlesAndSoftTypes) {
    const std::string far = with("  aura_m { normal: 50 }\n}\ntype {\n  name: \"guard\"",
                                 "  aura_m { normal: 50 }\n  drag_ps: 3\n  representation { "
                                 "particle_beyond_m: 200 }\n}\ntype {\n  name: \"guard\"");
    const Outcome out =
        parse(far + kSheet + "budget { free_flight_m: 0.01 particles_m: 5 soft_share: 0.02 }\n");
    ASSERT_TRUE(out.ok) << format_errors("test", out.errors);
    for (const auto& [subject, budget, kind, pieces] :
         {std::tuple("bodies",
                     0.01,
                     out.settings.physics.body_integrator,
                     out.settings.physics.body_flight_pieces),
          std::tuple("props as points",
                     5.0,
                     out.settings.physics.particle_integrator,
                     out.settings.physics.particle_flight_pieces)}) {
        const MethodPlan& plan = plan_of(out, subject);
        ASSERT_TRUE(plan.choice && plan.choice->chosen) << subject;
        const auto& c = plan.choice->candidates[*plan.choice->chosen];
        EXPECT_LE(c.error, budget);
        EXPECT_EQ(static_cast<IntegratorKind>(c.code), kind);
        EXPECT_EQ(c.pieces, pieces);
    }
    const MethodPlan& sheet = plan_of(out, "soft type sheet");
    ASSERT_TRUE(sheet.choice && sheet.choice->chosen);
    const auto& c = sheet.choice->candidates[*sheet.choice->chosen];
    EXPECT_LE(c.error, 0.02);
    EXPECT_EQ(static_cast<SoftMethod>(c.code), out.settings.softs[0]->solver.method);
    EXPECT_EQ(c.pieces, out.settings.softs[0]->solver.substeps);
    const std::string text = methods_text(out.settings);
    for (const auto& other : sheet.choice->candidates) {
        EXPECT_NE(text.find(physics::method_selection::name_of(other)), std::string::npos);
        EXPECT_NE(text.find(other.refused), std::string::npos);
    }
    EXPECT_NE(text.find("the cheapest that keeps the budget"), std::string::npos) << text;
    EXPECT_NE(text.find("budget 0.02 of its size"), std::string::npos) << text;
}

TEST(ErrorBudget, ChoosesTheSameEachTime) {
    const std::string text = kValid + kSheet + "budget { free_flight_m: 0.1 soft_share: 0.02 }\n";
    EXPECT_EQ(methods_text(parse(text).settings), methods_text(parse(text).settings));
}

TEST(ErrorBudget, RefusesAnIntegratorThatCannotBearADrag) {
    expect_single(with_drag("100") + "physics { body_integrator: EXPLICIT_EULER }\n",
                  "body_integrator",
                  "drag x h = 3.333, at most 2");
    // With a budget it may be cut into pieces; this one is not enough.
    expect_single(
        with_drag("1000") + "physics { body_integrator: RK2 }\nbudget { free_flight_m: 0.1 }\n",
        "body_integrator",
        "the cheapest that keeps it is");
    EXPECT_TRUE(parse(with_drag("100")).ok);
}

TEST(ErrorBudget, RefusesANamedIntegratorThatMissesIt) {
    // g h t / 2 in eight pieces of 1/30 s: 41 mm.
    const std::string text =
        kValid + "physics { body_integrator: EXPLICIT_EULER }\nbudget { free_flight_m: 0.04 }\n";
    expect_single(text, "body_integrator", "explicit_euler x 8: off by 0.0408");
    expect_single(text, "body_integrator", "the cheapest that keeps it is default x 1");
    const Outcome wide = parse(kValid + "physics { body_integrator: EXPLICIT_EULER }\n" +
                               "budget { free_flight_m: 0.1 }\n");
    ASSERT_TRUE(wide.ok);
    EXPECT_EQ(wide.settings.physics.body_flight_pieces, 4);
}

TEST(ErrorBudget, SaysWhatComesNearestWhereNothingKeepsIt) {
    expect_single(kValid + "budget {\n  free_flight_m: 1e-9\n}\n",
                  "free_flight_m",
                  "nothing that was tried keeps it: the best is");
    expect_single(kValid + kSheet + "budget {\n  soft_share: 1e-7\n}\n",
                  "soft_share",
                  "soft type sheet: nothing that was tried keeps it: the best is");
}

TEST(ErrorBudget, RefusesASoftMethodThatMissesItOrIsUnstable) {
    const std::string named =
        with("  }\n  mass_kg: 1", "    method: XPBD\n    substeps: 1\n  }\n  mass_kg: 1", kSheet);
    expect_single(
        kValid + named + "budget { soft_share: 0.002 }\n", "method: XPBD", "xpbd x 1: off by");
    expect_single(
        kValid + named + "budget { soft_share: 0.002 }\n", "method: XPBD", "(budget.soft_share); ");
    EXPECT_TRUE(parse(kValid + named).ok);
    // Refused with and without a budget, before anything is simulated.
    const std::string stiff = with(
        "stiffness_npm: 500",
        "stiffness_npm: 1e8",
        with("  }\n  mass_kg: 1", "    method: SEMI_IMPLICIT_EULER\n  }\n  mass_kg: 1", kSheet));
    expect_single(kValid + stiff, "method: SEMI", "256 substeps are too few");
    expect_single(kValid + stiff + "budget { soft_share: 0.1 }\n", "method: SEMI", "omega h = ");
}

/// Hail lives for a second: 1 s of a fall in one piece of 1/30 s is off by 0.16 m.
TEST(ErrorBudget, CutsTheStepsOfParticles) {
    const std::string hail = R"(particles {
  name: "hail"
  cosmetic: false
  emitter { x_m: -50 y_m: 20 z_m: 0 rate_hz: 10 speed_min_mps: 5 lifetime_min_s: 1 }
}
)";
    const Outcome without = parse(kValid + hail);
    ASSERT_TRUE(without.ok) << format_errors("test", without.errors);
    EXPECT_EQ(without.settings.particles[0].def.pieces, 1);
    const Outcome out = parse(kValid + hail + "budget { particles_m: 0.05 }\n");
    ASSERT_TRUE(out.ok) << format_errors("test", out.errors);
    EXPECT_EQ(out.settings.particles[0].def.pieces, 4);
    const std::string text = methods_text(out.settings);
    EXPECT_NE(text.find("particle system hail: semi_implicit_euler x 4, the fewest pieces"),
              std::string::npos)
        << text;
    expect_single(kValid + hail + "budget {\n  particles_m: 1e-6\n}\n",
                  "particles_m",
                  "particle system hail: nothing that was tried keeps it");
}

TEST(ErrorBudget, MakesOneHullOfACompoundFromWhereItsErrorIsSmallEnough) {
    const std::string table = with("box { x_m: 1 y_m: 1 z_m: 1 }",
                                   "compound { part { box { } } part { box { } y_m: 1 } }");
    const Outcome never = parse(table);
    ASSERT_TRUE(never.ok) << format_errors("test", never.errors);
    EXPECT_EQ(never.settings.types[1].single_beyond_m, 0.0F);
    const Outcome out = parse(table + "budget { representation_rad: 0.01 }\n");
    ASSERT_TRUE(out.ok) << format_errors("test", out.errors);
    const world::EntityType& type = out.settings.types[1];
    const auto diameter = 2.0 * static_cast<double>(type.radius);
    EXPECT_NEAR(static_cast<double>(type.single_beyond_m),
                diameter * physics::method_selection::kSingleErrorShare / 0.01,
                1e-4);
    EXPECT_NE(methods_text(out.settings).find("type " + type.name + " far away: one hull beyond"),
              std::string::npos)
        << methods_text(out.settings);
    const Outcome named =
        parse(with("compound {", "representation { single_beyond_m: 70 }\n  compound {", table) +
              "budget { representation_rad: 0.01 }\n");
    ASSERT_TRUE(named.ok) << format_errors("test", named.errors);
    EXPECT_EQ(named.settings.types[1].single_beyond_m, 70.0F);
    // Bodies that hang on pins keep their method.
    const Outcome sheet = parse(kValid + kSheet + "budget { representation_rad: 0.01 }\n");
    ASSERT_TRUE(sheet.ok) << format_errors("test", sheet.errors);
    EXPECT_EQ(sheet.settings.types.back().single_beyond_m, 0.0F);
}

TEST(PropDrag, ReachesTheBody) {
    const Outcome out = parse(with_drag("2.5"));
    ASSERT_TRUE(out.ok) << format_errors("test", out.errors);
    const auto& crate = out.settings.types[1];
    EXPECT_EQ(zone::body_of(crate, out.settings.solids).damping.linear, 2.5F);
    EXPECT_EQ(zone::body_of(out.settings.types[0], out.settings.solids).damping.linear, 0.0F);
}

TEST(PropRollingFriction, ReachesTheBody) {
    const std::string text = with("  box { x_m: 1 y_m: 1 z_m: 1 }\n",
                                  "  box { x_m: 1 y_m: 1 z_m: 1 }\n  rolling_friction_m: 0.02\n"
                                  "  spinning_friction_m: 0.01\n");
    const Outcome out = parse(text);
    ASSERT_TRUE(out.ok) << format_errors("test", out.errors);
    const physics::BodyDef crate = zone::body_of(out.settings.types[1], out.settings.solids);
    EXPECT_EQ(crate.material.rolling_m, 0.02F);
    EXPECT_EQ(crate.material.spinning_m, 0.01F);
    const physics::BodyDef other = zone::body_of(out.settings.types[0], out.settings.solids);
    EXPECT_EQ(other.material.rolling_m, 0.0F);
    expect_single(with("  box { x_m: 1 y_m: 1 z_m: 1 }\n",
                       "  box { x_m: 1 y_m: 1 z_m: 1 }\n  rolling_friction_m: 0.02\n") +
                      "physics { method: DIRECT }\n",
                  "rolling_friction_m",
                  "SOFT_STEP");
}

TEST(PropRollingFriction, BelongsToRigidProps) {
    expect_single(with("  brain: \"guard\"\n", "  brain: \"guard\"\n  rolling_friction_m: 1\n"),
                  "rolling_friction_m",
                  "rigid props only");
    expect_single(kValid + with("  mass_kg: 1", "  spinning_friction_m: 1\n  mass_kg: 1", kSheet),
                  "spinning_friction_m",
                  "rigid props only");
    expect_single(with("  box { x_m: 1 y_m: 1 z_m: 1 }\n",
                       "  box { x_m: 1 y_m: 1 z_m: 1 }\n  rolling_friction_m: -1\n"),
                  "rolling_friction_m",
                  "out of range");
}

TEST(ErrorBudget, HasRanges) {
    expect_single(kValid + "budget { free_flight_m: -1 }\n", "free_flight_m", "out of range");
    expect_single(kValid + "budget { soft_share: nan }\n", "soft_share", "not a finite number");
    expect_single(kValid + "budget { flight_s: 0 }\n", "flight_s", "out of range");
    expect_single(with("  brain: \"guard\"\n", "  brain: \"guard\"\n  drag_ps: 1\n"),
                  "drag_ps",
                  "belongs to props only");
    expect_single(kValid + with("  mass_kg: 1", "  drag_ps: 1\n  mass_kg: 1", kSheet),
                  "drag_ps",
                  "soft.drag_ps");
}

/// A spring on the coarse lattice stands for those that it replaces: the same stiffness in a row,
/// and the same mass.
TEST(CoarsenedSoftTypes, AreTheSameMatter) {
    const std::string forms = kSheet + R"(
type { name: "rope" soft { rope { length_m: 4 nodes: 41 stiffness_npm: 4000 } } mass_kg: 3 }
type { name: "jelly" soft { jelly { nodes_x: 7 nodes_y: 7 nodes_z: 7 stiffness_npm: 600 } } mass_kg: 9 }
type { name: "balloon" soft { balloon { splits: 4 } } mass_kg: 2 }
)";
    const Outcome out = parse(kValid + forms);
    ASSERT_TRUE(out.ok) << format_errors("test", out.errors);
    for (const auto& type : out.settings.config->type()) {
        if (!type.has_soft()) {
            continue;
        }
        const auto fine = build_soft(type);
        const auto coarse = build_soft(coarsened(type, 2));
        ASSERT_TRUE(fine.ok() && coarse.ok()) << type.name();
        double mass = 0.0;
        for (const auto& node : coarse->def.nodes) {
            mass += static_cast<double>(node.mass);
        }
        EXPECT_NEAR(mass, type.mass_kg(), 1.0e-5 * type.mass_kg()) << type.name();
        EXPECT_LT(coarse->def.nodes.size(), fine->def.nodes.size());
        // Stiffness times length to the power of 3 - d stays the same for a body of d dimensions,
        // and so does damping. A row of n springs has 1/n of the stiffness, n rows have n times it.
        const auto& a = fine->def.springs[0];
        const auto& b = coarse->def.springs[0];
        const double power = type.name() == "rope" ? -1.0 : (type.name() == "jelly" ? 1.0 : 0.0);
        const double scale = std::pow(static_cast<double>(b.rest / a.rest), power);
        // The mass is dealt out evenly. The coarse lattice has a larger share of rim nodes, so
        // these get too much. The critical damping follows the root of a node's mass.
        const double dimensions = power + 2.0;
        const double rim =
            std::sqrt(static_cast<double>(fine->def.nodes.size()) /
                      static_cast<double>(coarse->def.nodes.size()) / std::pow(2.0, dimensions));
        EXPECT_NEAR(static_cast<double>(b.stiffness / a.stiffness), scale, 0.05) << type.name();
        EXPECT_NEAR(static_cast<double>(b.damping / a.damping), scale * rim, 0.02) << type.name();
        const auto pinned = [](const SoftShape& shape) {
            return std::count_if(shape.def.nodes.begin(), shape.def.nodes.end(), [](const auto& n) {
                return n.pinned;
            });
        };
        EXPECT_EQ(pinned(*coarse), pinned(*fine)) << type.name();
    }
}

TEST(ErrorBudget, TriesALargeClothOnACoarserLattice) {
    const std::string large =
        with("columns: 9 rows: 9", "columns: 64 rows: 64", with("column: 8", "column: 63", kSheet));
    const Outcome out = parse(kValid + large + "budget { soft_share: 0.05 }\n");
    ASSERT_TRUE(out.ok) << format_errors("test", out.errors);
    const MethodPlan& plan = plan_of(out, "soft type sheet");
    EXPECT_NE(plan.choice->basis.find("of 484 nodes"), std::string::npos) << plan.choice->basis;
    EXPECT_NE(plan.choice->basis.find("a coarser lattice stands for the whole"), std::string::npos);
    // A body that holds on 22 x 22 nodes in n substeps takes three times as many passes on 64 x 64.
    for (const auto& c : plan.choice->candidates) {
        EXPECT_TRUE(c.method != "xpbd" || c.pieces % 3 == 0) << c.pieces;
    }
}

}  // namespace
}  // namespace zoned::config::test
