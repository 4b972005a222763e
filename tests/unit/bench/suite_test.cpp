#include "tests/bench/suite.h"

#include "tests/bench/simulator.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <string>

namespace zoned::bench {
namespace {

using testing::Contains;
using testing::ElementsAre;
using testing::IsEmpty;

const Suite& suite(const std::vector<Suite>& suites, const std::string& name) {
    for (const Suite& s : suites) {
        if (s.name == name) {
            return s;
        }
    }
    throw std::out_of_range(name);
}

TEST(Suites, NameThePhysicsScenesAsAgreed) {
    const std::vector<Suite> suites = all_suites();
    const Suite& physics = suite(suites, "physics");
    EXPECT_THAT(physics.scenes,
                ElementsAre("S1",
                            "S2",
                            "S2x100",
                            "S2x1000",
                            "S3",
                            "S4",
                            "S5",
                            "S5b",
                            "S6a",
                            "S6b",
                            "S7",
                            "S8",
                            "S9",
                            "S11",
                            "S12",
                            "S13",
                            "S14",
                            "S15",
                            "S16",
                            "S17a",
                            "S17b",
                            "S17c",
                            "S18"));
    EXPECT_THAT(physics.methods, Contains("default"));
    EXPECT_THAT(physics.methods, Contains("bullet/default"));
    EXPECT_THAT(physics.methods, Contains("ode/exact"));
}

TEST(Suites, AddRowsWithErrorsAndRatios) {
    Session session;
    session.quick = true;
    session.scenes = {"S2"};
    session.methods = {"default", "bullet"};
    const std::vector<Suite> suites = all_suites();
    suite(suites, "physics").run(session);
    ASSERT_GE(session.results.rows.size(), 2u);
    const Row& ours = session.results.rows[0];
    EXPECT_EQ(ours.suite, "physics");
    EXPECT_EQ(ours.scene, "S2");
    EXPECT_EQ(ours.method, "default");
    EXPECT_EQ(ours.peer, "");
    EXPECT_EQ(ours.error_unit, "m");
    EXPECT_GT(ours.time_us_p50, 0.0);
    EXPECT_GE(ours.time_us_p99, ours.time_us_p50);
    EXPECT_NE(ours.find_metric("bullet_ratio"), nullptr);
    EXPECT_NE(ours.find_metric("y_ratio"), nullptr);
    EXPECT_EQ(ours.state_hash.size(), 16u);
    const Row& theirs = session.results.rows[1];
    EXPECT_EQ(theirs.peer, "bullet");
    EXPECT_EQ(*theirs.find_metric("bullet_ratio"), 1.0);
}

// The cases of a row run side by side: it has the error of each.
TEST(Suites, GiveTheErrorOfEachCaseOfARow) {
    Session session;
    session.quick = true;
    session.scenes = {"S11"};
    session.methods = {"bullet"};
    const std::vector<Suite> suites = all_suites();
    suite(suites, "physics").run(session);
    ASSERT_FALSE(session.results.rows.empty());
    const Row& row = session.results.rows.front();
    EXPECT_EQ(row.parameter, "pair");
    double worst = 0.0;
    for (const int ratio : {1, 2, 5, 10, 20, 50, 100, 200, 1000}) {
        const double* error = row.find_metric("error_ratio_" + std::to_string(ratio));
        ASSERT_NE(error, nullptr);
        worst = std::max(worst, *error);
    }
    EXPECT_EQ(row.error, worst);
}

TEST(Suites, FindNoPairMissingOrTwiceInOurStructures) {
    Session session;
    session.quick = true;
    const std::vector<Suite> suites = all_suites();
    suite(suites, "broadphase").run(session);
    ASSERT_FALSE(session.results.rows.empty());
    for (const Row& row : session.results.rows) {
        EXPECT_EQ(row.error, 0.0) << row.peer << row.method;
        EXPECT_GT(*row.find_metric("pairs_exact"), 50.0);
        EXPECT_EQ(*row.find_metric("doubles"), 0.0) << row.peer << row.method;
    }
}

TEST(Suites, JudgeOurRaysExactOverAField) {
    Session session;
    session.quick = true;
    session.scenes = {"field"};
    session.methods = {"default"};
    const std::vector<Suite> suites = all_suites();
    suite(suites, "queries").run(session);
    ASSERT_EQ(session.results.rows.size(), 2u);
    for (const Row& row : session.results.rows) {
        // Floats at 100 m have a grain of 8e-6 m; a ray that meets a face at a slant spreads it.
        EXPECT_LT(row.error, 1e-3) << row.parameter;
        EXPECT_GT(*row.find_metric("hit_share"), 0.3);
        EXPECT_GT(*row.find_metric("rays_per_s"), 0.0);
    }
}

// Orders of theory where the shortest two steps are short enough, from runs that --quick does not
// shorten; free rotation with its momentum.
TEST(Suites, FindTheOrdersOfTheIntegrators) {
    Session session;
    session.quick = true;
    const std::vector<Suite> suites = all_suites();
    suite(suites, "integrators").run(session);
    const std::map<std::string, double> orders{{"explicit_euler", 1},
                                               {"implicit_euler", 1},
                                               {"semi_implicit_euler", 1},
                                               {"verlet", 2},
                                               {"velocity_verlet", 2},
                                               {"rk2", 2},
                                               {"rk4", 4},
                                               {"default", 1}};
    std::map<std::string, int> rows;
    for (const Row& row : session.results.rows) {
        ++rows[row.scene];
        EXPECT_GT(row.time_us_p50, 0.0) << row.scene << row.method;
        const double* order = row.find_metric("order");
        if (row.scene == "oscillator" && row.parameter == "dt=0.0015625") {
            ASSERT_EQ(order != nullptr, row.method != "adaptive");
            EXPECT_NEAR(order == nullptr ? 0.0 : *order,
                        order == nullptr ? 0.0 : orders.at(row.method),
                        0.1)
                << row.method;
        }
        if (row.scene == "stiff_spring" && row.parameter == "dt=0.016667") {
            const bool borne = row.method == "implicit_euler" || row.method == "adaptive";
            EXPECT_EQ(*row.find_metric("stable"), borne ? 1.0 : 0.0) << row.method;
            EXPECT_EQ(row.error < 1e-3, borne) << row.method;
        }
        if (row.scene == "free_spin" && row.parameter == "dt=0.016667" && row.method == "default") {
            EXPECT_LT(std::abs(*row.find_metric("energy_error_60s")), 2e-4);
            EXPECT_LT(*row.find_metric("momentum_turned_60s_degrees"), 0.1);
        }
    }
    EXPECT_EQ(rows,
              (std::map<std::string, int>{{"oscillator", 54},
                                          {"stiff_spring", 54},
                                          {"kepler", 54},
                                          {"pendulum", 54},
                                          {"projectile_drag", 54},
                                          {"free_spin", 42},
                                          {"free_flight", 8}}));
}

// Free flight of bodies and points is exact but for rounding at 11 m; landed ones sink in by less
// than a millimetre. Angular momentum is kept to rounding. No order changes the answer to a ray.
TEST(Suites, JudgeWhatBodiesAndRaysCost) {
    Session session;
    session.quick = true;
    const std::vector<Suite> suites = all_suites();
    suite(suites, "bodies").run(session);
    std::map<std::string, int> rows;
    for (const Row& row : session.results.rows) {
        ++rows[row.scene];
        EXPECT_GT(row.time_us_p50, 0.0) << row.scene << row.method;
        if (row.scene == "rays") {
            EXPECT_LT(row.error, 1e-4) << row.method;
            EXPECT_EQ(*row.find_metric("rays_of_other_answer"), 0.0) << row.method;
            EXPECT_GT(*row.find_metric("rays_per_s"), 0.0);
            EXPECT_GT(*row.find_metric("hit_share"), 0.2);
        } else {
            EXPECT_LT(row.error, 1e-3) << row.scene << row.method;
            EXPECT_GT(*row.find_metric("ns_per_body"), 0.0);
        }
        if (row.scene == "fall") {
            EXPECT_LT(*row.find_metric("error_flying_m_max"), 1e-4) << row.method;
        }
    }
    EXPECT_EQ(rows, (std::map<std::string, int>{{"spin", 6}, {"fall", 2}, {"rays", 4}}));
}

// A pass of Gauss-Seidel lowers the residual; the exact solver leaves only rounding.
TEST(Suites, ShowTheResidualFallWithThePasses) {
    Session session;
    session.quick = true;
    session.scenes = {"column_x100"};
    session.methods = {"gauss_seidel", "direct"};
    const std::vector<Suite> suites = all_suites();
    suite(suites, "solvers").run(session);
    double last = INFINITY;
    int exact = 0;
    for (const Row& row : session.results.rows) {
        EXPECT_EQ(row.error_unit, "m/s");
        if (row.method == "direct") {
            EXPECT_LT(row.error, 1e-6) << row.scene;
            ++exact;
        } else if (row.scene == "column_x100") {
            EXPECT_LT(row.error, last) << row.parameter;
            last = row.error;
        }
    }
    EXPECT_EQ(exact, 2);
}

TEST(Session, ChoosesPeersByNameAndMethod) {
    Session session;
    EXPECT_TRUE(session.wants_method("exact", "ode"));
    session.methods = {"default", "ode/exact"};
    EXPECT_TRUE(session.wants_method("default", ""));
    EXPECT_FALSE(session.wants_method("default", "bullet"));
    EXPECT_TRUE(session.wants_method("exact", "ode"));
    EXPECT_FALSE(session.wants_method("default", "ode"));
}

/// The same end state twice: a row's values do not depend on when it was measured.
TEST(Engines, RepeatARunBitForBit) {
    const scenario::Description scene = scenario::column(5, 1.0);
    for (const auto& engines : {zoned_engines(), bullet_engines(), ode_engines()}) {
        std::vector<Vec3d> ends;
        for (int run = 0; run < 2; ++run) {
            const auto simulator = engines.front().build(scene);
            for (int i = 0; i < 60; ++i) {
                simulator->step();
            }
            ends.push_back(simulator->motion(5).pose.position);
        }
        EXPECT_EQ(ends[0], ends[1]) << engines.front().peer;
    }
}

/// Free fall from rest for one second. A symplectic Euler step is off by g dt t / 2 = 0.082 m, an
/// exact one by nothing.
TEST(Engines, AllFallAlike) {
    scenario::Description scene = scenario::bounce(0.0, 1.0, 1.0 / 60.0);
    for (const auto& engines : {zoned_engines(), bullet_engines(), ode_engines()}) {
        const auto simulator = engines.front().build(scene);
        for (int i = 0; i < 60; ++i) {
            simulator->step();
        }
        const Motion m = simulator->motion(1);
        EXPECT_NEAR(m.pose.position.y(), 10.5 - 0.5 * 9.81, 0.085) << engines.front().peer;
        EXPECT_NEAR(m.velocity.y(), -9.81, 1e-4) << engines.front().peer;
        EXPECT_NEAR(simulator->motion(0).pose.position.y(), -1.0, 1e-6);
    }
}

}  // namespace
}  // namespace zoned::bench
