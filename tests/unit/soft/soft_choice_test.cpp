// Soft choices: the probe against closed forms, and the cheapest method that keeps a budget.
#include "server/physics/method_selection/soft_choice.h"

#include "server/physics/method_selection/cost_table.h"
#include "server/physics/method_selection/soft_probe.h"
#include "tests/scenario/cloth_scene.h"
#include "tests/unit/soft/soft_test.h"

#include <cmath>

namespace zoned::physics::method_selection {
namespace {

using soft::SoftDef;
using soft::SoftMethod;

constexpr float kTick = 1.0F / 30;

SoftDef hanging(int n, float stiffness) {
    SoftDef def = soft::cloth(n, stiffness);
    def.material.drag = 0.5F;
    return def;
}

soft::SoftSolver solver_of(SoftMethod method, int substeps, const SoftDef& def) {
    soft::SoftSolver solver = def.solver;
    solver.method = method;
    solver.substeps = substeps;
    return solver;
}

/// Two masses and a spring, let go at 1.2 of its length: w^2 = 2 k / m.
TEST(SoftProbe, LetsGoWhatIsNotPinned) {
    SoftDef def;
    def.nodes.resize(2);
    def.nodes[1].position = Vec3(1, 0, 0);
    def.springs.push_back({0, 1, 1.0F, 50.0F, 0.0F, soft::SpringKind::kStructural});
    const SoftProbe probe(def, Vec3(0, -9.81F, 0), kTick);
    EXPECT_FALSE(probe.pinned());
    const ProbeReference reference = probe.reference(1.0e-3);
    ASSERT_EQ(reference.run.places.size(), 20U);
    for (std::size_t moment = 0; moment < 10; ++moment) {
        const double t = 0.1 * static_cast<double>(moment + 1);
        const Vec3 apart = reference.run.places[2 * moment + 1] - reference.run.places[2 * moment];
        // Half a substep late, at 0.2 m x 10 rad/s and 1/3840 s.
        EXPECT_NEAR(static_cast<double>(apart.x()),
                    1.0 + 0.2 * std::cos(10.0 * t),
                    2.0 * 0.5 / 3840 + 1e-5);
        EXPECT_EQ(apart.y(), 0.0F);
    }
    EXPECT_LT(reference.change, 1.0e-3);
}

/// A reference made by another program: the leapfrog in doubles of the benchmark's cloth.
TEST(SoftProbe, FindsWhatAnIndependentSolutionFinds) {
    scenario::Cloth cloth;
    cloth.nodes = 12;
    cloth.stiffness = 1000.0;
    cloth.dt = static_cast<double>(kTick);
    soft::ClothDef def;
    def.nx = def.nz = 12;
    def.size_x = def.size_z = 2.0F;
    def.stiffness = 1000.0F;
    def.shear_stiffness = 500.0F;
    def.bend_stiffness = 100.0F;
    def.damping_share = static_cast<float>(cloth.damping_share);
    def.pins = {{0, 0}, {11, 0}};
    def.coarsen = 1;
    SoftDef built = *soft::build_cloth(def);
    built.material.drag = static_cast<float>(cloth.drag);
    const SoftProbe probe(built, Vec3(0, -9.81F, 0), kTick);
    const ProbeReference reference = probe.reference(0.01);
    const std::vector<Vec3d> other = scenario::cloth_reference(cloth, 1.0, 1.2);
    ASSERT_EQ(reference.run.places.size(), 10 * other.size());
    std::vector<Vec3d> last;
    for (std::size_t i = 9 * other.size(); i < reference.run.places.size(); ++i) {
        last.push_back(reference.run.places[i].cast<double>());
    }
    // Twice the change by a halving, the benchmark's own error, and a tenth of a percent for
    // floats.
    const double own = scenario::mean_distance(other, scenario::cloth_reference(cloth, 1.0, 0.8));
    EXPECT_LT(scenario::mean_distance(last, other) / 2.0,
              2.0 * reference.change + own / 2.0 + 1.0e-3);
    EXPECT_LT(reference.change, 1.0e-3);
}

TEST(SoftProbe, TakesXpbdWhereSpringsAreTooStiffForExplicitOnes) {
    const SoftDef def = hanging(16, 1.0e9F);
    const ProbeReference reference = SoftProbe(def, Vec3(0, -9.81F, 0), kTick).reference(0.01);
    EXPECT_EQ(reference.how.find("XPBD in "), 0U) << reference.how;
    EXPECT_FALSE(reference.run.broke);
}

TEST(SoftChoice, IsTheCheapestOfAllThatKeepTheBudget) {
    for (const float stiffness : {20.0F, 3.0e3F}) {
        const SoftDef def = hanging(12, stiffness);
        const SoftSubject subject{"soft type sheet", def, def};
        const SoftProbe probe(def, subject.gravity, kTick);
        const SweepCounts counts = counts_of(def);
        for (const double budget : {0.03, 0.01}) {
            const MethodChoice choice = choose_soft(subject, budget);
            const ProbeReference reference = probe.reference(budget);
            ASSERT_TRUE(choice.chosen) << stiffness << " " << budget;
            const MethodCandidate& c = choice.candidates[*choice.chosen];
            EXPECT_LE(c.error, budget);
            // All others by hand, without the order and the shortcuts of the choice.
            double least = INFINITY;
            for (const SoftMethod method : kSoftMethods) {
                for (int n = 1; n <= 256; n *= 2) {
                    SoftDef tried = def;
                    tried.solver = solver_of(method, n, def);
                    if (method == SoftMethod::kSemiImplicitEuler ||
                        (method == SoftMethod::kImplicitEuler && n > 64)) {
                        continue;  // its substeps are no powers of two; more are not offered
                    }
                    const ProbeRun run = probe.run(tried.solver);
                    if (probe.distance(run, reference.run) + reference.change <= budget) {
                        least = std::min(least,
                                         soft_cost_ns(method,
                                                      counts,
                                                      n,
                                                      run.newton_steps / probe.ticks(),
                                                      run.gradient_passes / probe.ticks()));
                    }
                }
            }
            EXPECT_LE(c.cost_ns, least) << name_of(c);
            const auto method = static_cast<SoftMethod>(c.code);
            if (method != SoftMethod::kSemiImplicitEuler) {
                EXPECT_EQ(c.cost_ns, least);
            }
            const ProbeRun again = probe.run(solver_of(method, c.pieces, def));
            EXPECT_EQ(c.error, probe.distance(again, reference.run) + reference.change);
        }
    }
}

TEST(SoftChoice, TakesExplicitSpringsWhereTheyAreSlackAndRefusesThemWhereTheyAreStiff) {
    const SoftDef slack = hanging(8, 5.0F);
    const MethodChoice loose = choose_soft({"soft type veil", slack, slack}, 0.02);
    ASSERT_TRUE(loose.chosen);
    EXPECT_EQ(loose.candidates[*loose.chosen].method, "semi_implicit_euler");
    const SoftDef stiff = hanging(8, 1.0e8F);
    const MethodChoice tight = choose_soft({"soft type sail", stiff, stiff}, 0.05);
    bool refused = false;
    for (const MethodCandidate& c : tight.candidates) {
        if (c.method == "semi_implicit_euler") {
            refused = true;
            EXPECT_NE(c.refused.find("omega h = "), std::string::npos) << c.refused;
            EXPECT_TRUE(std::isnan(c.error));
        }
    }
    EXPECT_TRUE(refused);
    ASSERT_TRUE(tight.chosen);
    EXPECT_NE(tight.candidates[*tight.chosen].method, "semi_implicit_euler");
}

TEST(SoftChoice, KeepsToWhatIsNamedAndSaysWhatNothingKeeps) {
    const SoftDef def = hanging(10, 1.0e3F);
    const SoftSubject subject{"soft type sheet", def, def};
    const std::array xpbd{SoftMethod::kXpbd};
    const MethodChoice one = choose_soft(subject, 0.5, xpbd, 3);
    ASSERT_EQ(one.candidates.size(), 1U);
    EXPECT_EQ(name_of(one.candidates[0]), "xpbd x 3");
    EXPECT_TRUE(one.chosen);
    const MethodChoice none = choose_soft(subject, 1.0e-9, xpbd);
    EXPECT_FALSE(none.chosen);
    ASSERT_NE(none.best(), nullptr);
    EXPECT_GT(none.best()->error, 1.0e-9);
}

TEST(SoftChoice, IsTheSameEachTime) {
    const SoftDef def = hanging(10, 1.0e3F);
    const SoftSubject subject{"soft type sheet", def, def};
    const MethodChoice a = choose_soft(subject, 0.01);
    const MethodChoice b = choose_soft(subject, 0.01);
    ASSERT_EQ(a.candidates.size(), b.candidates.size());
    EXPECT_EQ(a.chosen, b.chosen);
    for (std::size_t i = 0; i < a.candidates.size(); ++i) {
        EXPECT_EQ(name_of(a.candidates[i]), name_of(b.candidates[i]));
        EXPECT_EQ(a.candidates[i].cost_ns, b.candidates[i].cost_ns);
        EXPECT_EQ(a.candidates[i].refused, b.candidates[i].refused);
    }
}

}  // namespace
}  // namespace zoned::physics::method_selection
