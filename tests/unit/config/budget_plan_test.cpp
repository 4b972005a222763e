// Budgets of a whole world: which settings they fill in, what is refused, and the models behind.
#include "server/config/plan/budget_plan.h"

#include "server/config/expand/load_settings.h"
#include "server/config/expand/method_plan.h"
#include "server/config/plan/error_models.h"
#include "server/config/plan/pass_costs.h"
#include "server/physics/scene/scene.h"
#include "tests/unit/config/config_helpers.h"

#include <algorithm>
#include <cmath>

namespace zoned::config::test {
namespace {

const std::string kUnsetBounds =
    with(" position_bound_m: 0.5", "", with(" position_bound_m: 0.05", ""));

const MethodPlan* plan_for_path(const Outcome& out, const std::string& path) {
    for (const MethodPlan& plan : out.settings.methods) {
        if (plan.subject == path) {
            return &plan;
        }
    }
    return nullptr;
}

/// The sag of a pile of one, and the bound of the nearest level, m.
double share_of_position(const Outcome& out) {
    return static_cast<double>(out.settings.physics.error_budget_m) +
           static_cast<double>(out.settings.replication.lods[0].position_m);
}

TEST(BudgetPlan, WithoutBudgetsOfTheWorldFillsNothingIn) {
    const Outcome plain = parse(kUnsetBounds);
    const Outcome parts = parse(kUnsetBounds + "budget { viewers: 7 }\n");
    ASSERT_TRUE(plain.ok && parts.ok);
    EXPECT_EQ(plan_for_path(plain, "physics.error_budget_m"), nullptr);
    EXPECT_EQ(plan_for_path(parts, "physics.error_budget_m"), nullptr);
    EXPECT_EQ(plain.settings.digest, parts.settings.digest);
    EXPECT_EQ(plain.settings.text.find("error_budget_m"), std::string::npos);
    EXPECT_FLOAT_EQ(plain.settings.physics.error_budget_m, 0.005F);
    EXPECT_FLOAT_EQ(plain.settings.replication.lods[0].position_m, 0.05F);
}

TEST(BudgetPlan, SharesAPositionBudgetAmongContactsAndBound) {
    for (const double budget : {0.02, 0.05, 0.2, 1.0}) {
        const Outcome out =
            parse(kUnsetBounds + "budget { position_m: " + std::to_string(budget) + " }\n");
        ASSERT_TRUE(out.ok) << format_errors("test", out.errors);
        EXPECT_LE(share_of_position(out), budget * 1.00001);
        EXPECT_GT(share_of_position(out), budget * 0.99);
        EXPECT_GT(out.settings.replication.lods[1].position_m,
                  out.settings.replication.lods[0].position_m);
        EXPECT_LT(out.settings.replication.quantization.position_quantum_m(),
                  0.1F * out.settings.replication.lods[0].position_m);
        const MethodPlan* plan = plan_for_path(out, "position");
        ASSERT_NE(plan, nullptr);
        ASSERT_TRUE(plan->choice && plan->choice->chosen);
        const auto& candidates = plan->choice->candidates;
        EXPECT_GT(candidates.size(), 3U);
        for (const auto& c : candidates) {
            EXPECT_GE(c.cost_ns, candidates[*plan->choice->chosen].cost_ns) << c.method;
        }
    }
}

TEST(BudgetPlan, KeepsTheTopOfAPileWithinTheBudget) {
    for (const int bodies : {2, 5, 10}) {
        std::string text = kUnsetBounds + "budget { position_m: 0.05 }\n";
        for (int k = 0; k < bodies; ++k) {
            text +=
                "entity { type: \"crate\" x_m: 20 y_m: " + std::to_string(0.5 + k) + " z_m: 3 }\n";
        }
        const Outcome out = parse(text);
        ASSERT_TRUE(out.ok) << format_errors("test", out.errors);
        const Pile pile{bodies, 9.81};
        const double tick_s = 1.0 / out.settings.tick_rate_hz;
        const int substeps = substeps_for(
            static_cast<double>(out.settings.physics.error_budget_m), pile.load_mps2(), tick_s);
        EXPECT_LE(pile_sag_m(pile, substeps, tick_s) +
                      static_cast<double>(out.settings.replication.lods[0].position_m),
                  0.05 * 1.00001)
            << bodies;
    }
}

TEST(BudgetPlan, KeepsWhatTheConfigGives) {
    const Outcome out = parse(with("lod { position_bound_m: 0.5 }", "lod { }") +
                              "physics { error_budget_m: 0.003 }\nbudget { position_m: 0.1 "
                              "free_flight_m: 0.5 }\n");
    ASSERT_TRUE(out.ok) << format_errors("test", out.errors);
    EXPECT_FLOAT_EQ(out.settings.physics.error_budget_m, 0.003F);
    EXPECT_FLOAT_EQ(out.settings.replication.lods[0].position_m, 0.05F);
    EXPECT_NE(out.settings.replication.lods[1].position_m, 0.05F);
    for (const char* path :
         {"physics.error_budget_m", "lod[0].position_bound_m", "budget.free_flight_m"}) {
        ASSERT_NE(plan_for_path(out, path), nullptr) << path;
        EXPECT_EQ(plan_for_path(out, path)->reason, kAsConfigured) << path;
    }
    const MethodPlan* filled = plan_for_path(out, "lod[1].position_bound_m");
    ASSERT_NE(filled, nullptr);
    EXPECT_NE(filled->reason, kAsConfigured);
    EXPECT_NE(methods_text(out.settings).find("lod[0].position_bound_m: 0.05, as configured"),
              std::string::npos)
        << methods_text(out.settings);
}

TEST(BudgetPlan, RefusesSettingsThatLeaveNoRoom) {
    expect_single(with("lod { radius_m: 30 position_bound_m: 0.05 }",
                       "lod { radius_m: 30\n position_bound_m: 0.05 }") +
                      "budget { position_m: 0.04 }\n",
                  "position_bound_m: 0.05",
                  "leaves nothing of budget.position_m 0.04");
    expect_single(
        kUnsetBounds + "physics {\n error_budget_m: 0.1\n}\nbudget { position_m: 0.04 }\n",
        "error_budget_m: 0.1",
        "leaves nothing of budget.position_m 0.04");
    expect_single(kUnsetBounds + "budget {\n position_m: 0.0005\n}\n",
                  "position_m: 0.0005",
                  "cannot be kept");
    expect_single(with("name: \"test\"\n", "name: \"test\"\n  tick_rate_hz: 10\n") +
                      "budget { time_s: 0.1 }\n",
                  "tick_rate_hz: 10",
                  "two ticks are 0.2 s: more than budget.time_s 0.1");
    expect_single(kValid +
                      "budget {\n bytes_per_client_s: 2000\n}\nreplication {\n "
                      "budget_bytes_per_s: 4000\n}\n",
                  "budget_bytes_per_s: 4000",
                  "more than budget.bytes_per_client_s 2000");
}

TEST(BudgetPlan, MakesTheSameSettingsOfItsOwnText) {
    const Outcome first = parse(kUnsetBounds +
                                "budget { position_m: 0.03 orientation_rad: 0.05 time_s: 0.08 "
                                "bytes_per_client_s: 9000 cpu_us_per_tick: 800 }\n");
    ASSERT_TRUE(first.ok) << format_errors("test", first.errors);
    const Outcome again = parse(first.settings.text);
    ASSERT_TRUE(again.ok) << format_errors("test", again.errors);
    EXPECT_EQ(first.settings.digest, again.settings.digest);
    EXPECT_EQ(first.settings.text, again.settings.text);
    EXPECT_EQ(first.settings.physics.error_budget_m, again.settings.physics.error_budget_m);
    EXPECT_EQ(first.settings.tick_rate_hz, again.settings.tick_rate_hz);
}

TEST(BudgetPlan, TakesTheLowestTickRateThatTimeAllows) {
    for (const auto& [time_s, rate_hz] : {std::pair{0.2, 10.0},
                                          std::pair{0.1, 20.0},
                                          std::pair{0.08, 30.0},
                                          std::pair{0.02, 120.0}}) {
        const Outcome out = parse(kValid + "budget { time_s: " + std::to_string(time_s) + " }\n");
        ASSERT_TRUE(out.ok) << format_errors("test", out.errors);
        EXPECT_EQ(out.settings.tick_rate_hz, rate_hz);
        EXPECT_LE(out.settings.replication.silence_ticks / rate_hz, 0.5);
        EXPECT_EQ(out.settings.ai.reduce_far, 4.0 / rate_hz <= time_s);
    }
}

TEST(BudgetPlan, TurnsBudgetsIntoBitsBytesAndWork) {
    const Outcome out = parse(with("lod { radius_m: 30", "lod { radius_m: 30 ") +
                              "ai { pathfinding { } }\nbudget { orientation_rad: 0.02 "
                              "bytes_per_client_s: 9000 cpu_us_per_tick: 800 }\n");
    ASSERT_TRUE(out.ok) << format_errors("test", out.errors);
    const wire::Quantization& q = out.settings.replication.quantization;
    EXPECT_FLOAT_EQ(out.settings.replication.lods[0].orientation_rad, 0.02F);
    EXPECT_LE(q.orientation_quantum_rad(false), 0.02F / 8.0F);
    EXPECT_LE(q.orientation_quantum_rad(true), 0.02F / 8.0F);
    EXPECT_GT(orientation_quantum_rad(q.orientation_bits - 1), 0.02 / 8.0);
    EXPECT_EQ(out.settings.replication.budget_bytes_per_s, 9000U);
    EXPECT_EQ(out.settings.replication.codec_budget_us, 200U);
}

TEST(BudgetPlan, CodesForEachClientOnlyWhereBytesAreShort) {
    const auto codec = [](const char* bytes) {
        const Outcome out = parse(kValid +
                                  "scatter { type: \"guard\" count: 200 seed: 1 }\nbudget { "
                                  "bytes_per_client_s: " +
                                  bytes + " }\n");
        EXPECT_TRUE(out.ok) << format_errors("test", out.errors);
        return out.settings.replication.codec;
    };
    EXPECT_EQ(codec("1000000"), replication::Codec::kShared);
    EXPECT_EQ(codec("1500"), replication::Codec::kPerClient);
}

TEST(BudgetPlan, ScalesBudgetsThatAreGivenAndNotWhatFollowsFromThem) {
    const auto sets = [](const std::string& text) {
        const Outcome out = parse(text);
        EXPECT_TRUE(out.ok) << format_errors("test", out.errors);
        return scaled_budgets(out.settings, 0.5);
    };
    const std::vector<std::string> planned = sets(kUnsetBounds + "budget { position_m: 0.08 }\n");
    EXPECT_NE(std::find(planned.begin(), planned.end(), "budget.position_m=0.04"), planned.end());
    for (const std::string& set : planned) {
        EXPECT_EQ(set.find("position_bound_m"), std::string::npos) << set;
        EXPECT_EQ(set.find("physics.error_budget_m"), std::string::npos) << set;
    }
    const std::vector<std::string> plain = sets(kValid);
    EXPECT_NE(std::find(plain.begin(), plain.end(), "lod[0].position_bound_m=0.025"), plain.end());
    EXPECT_NE(std::find(plain.begin(), plain.end(), "physics.error_budget_m=0.0025"), plain.end());
}

TEST(BudgetPlan, NamesTheMethodsThatNoBudgetDecidesAbout) {
    const std::string budget = kUnsetBounds + "budget { position_m: 0.05 }\n";
    const Outcome plain = parse(budget);
    ASSERT_TRUE(plain.ok) << format_errors("test", plain.errors);
    ASSERT_NE(plan_for_path(plain, "physics.method"), nullptr);
    EXPECT_EQ(plan_for_path(plain, "physics.method")->used, "SOFT_STEP");
    EXPECT_EQ(plan_for_path(plain, "ai.avoidance.horizon_s"), nullptr);
    EXPECT_EQ(plan_for_path(plain, "ai.pathfinding.search"), nullptr);
    const Outcome given =
        parse(budget + "physics { method: DIRECT }\nai { avoidance { horizon_s: 2 } }\n");
    ASSERT_TRUE(given.ok) << format_errors("test", given.errors);
    EXPECT_EQ(plan_for_path(given, "physics.method")->used, "DIRECT");
    EXPECT_EQ(plan_for_path(given, "physics.method")->reason, kAsConfigured);
    EXPECT_EQ(plan_for_path(given, "ai.avoidance.horizon_s")->used, "2");
}

TEST(BudgetPlan, FillsInWhatAShippedWorldLeavesToIt) {
    Outcome out;
    ASSERT_TRUE(
        load_settings(ZONED_SOURCE_DIR "/config/solids.txtpb", {}, out.settings, out.errors))
        << format_errors("solids.txtpb", out.errors);
    EXPECT_EQ(out.settings.tick_rate_hz, 30.0);  // two ticks of 33 ms within 70 ms
    EXPECT_LE(share_of_position(out), 0.06 * 1.00001);
    EXPECT_GT(share_of_position(out), 0.06 * 0.99);
    ASSERT_EQ(out.settings.replication.lods.size(), 2U);
    EXPECT_FLOAT_EQ(out.settings.replication.lods[0].orientation_rad, 0.1F);
    EXPECT_EQ(out.settings.replication.budget_bytes_per_s, 32000U);
}

TEST(ErrorModels, FollowTheOrdersOfTheirMethods) {
    EXPECT_NEAR(contact_give_m(9.81, 1.0 / 120.0) / contact_give_m(9.81, 1.0 / 240.0), 4.0, 1e-9);
    EXPECT_NEAR(contact_give_m(20.0, 0.004) / contact_give_m(10.0, 0.004), 2.0, 1e-9);
    EXPECT_NEAR(publications_ps(0.01, 0.5, 10.0, 0.001) / publications_ps(0.04, 0.5, 10.0, 0.001),
                2.0,
                1e-9);
    EXPECT_EQ(publications_ps(1e9, 0.5, 2.0, 0.03), 0.5);
    EXPECT_NEAR(publications_ps(1e-12, 0.5, 2.0, 0.02), 50.0, 1e-9);
    EXPECT_GT(orientation_quantum_rad(8), 1.8 * orientation_quantum_rad(9));
}

TEST(ErrorModels, GiveMoreSubstepsToSmallerBudgetsAndLargerLoads) {
    int before = 64;
    for (const double budget : {1e-5, 1e-4, 1e-3, 1e-2, 1e-1}) {
        const int substeps = substeps_for(budget, 100.0, 1.0 / 30.0);
        EXPECT_LE(substeps, before);
        before = substeps;
        if (substeps < 64) {
            EXPECT_LE(contact_give_m(100.0, 1.0 / 30.0 / substeps), budget);
        }
    }
    EXPECT_EQ(before, 8);  // no substep is longer than 1/240 s
    EXPECT_GT(substeps_for(1e-3, 1000.0, 1.0 / 30.0), substeps_for(1e-3, 10.0, 1.0 / 30.0));
    EXPECT_GT(Pile({10, 9.81}).load_mps2(), Pile({2, 9.81}).load_mps2());
}

/// How far the top of a pile of cubes has sunk after three seconds, m.
double simulated_sag_m(int bodies, double budget_m) {
    physics::PhysicsSettings settings;
    settings.error_budget_m = static_cast<float>(budget_m);
    settings.sleep_after_s = 0.0F;
    physics::Scene scene(settings);
    physics::BodyDef ground;
    ground.kind = physics::BodyKind::kStatic;
    ground.shape = physics::Shape::plane();
    EXPECT_TRUE(scene.add(ground).ok());
    physics::BodyDef box;
    box.shape = physics::Shape::box(Vec3::Constant(0.5F));
    BodyId top;
    for (int k = 0; k < bodies; ++k) {
        box.position = Vec3(0.0F, 0.5F + static_cast<float>(k), 0.0F);
        top = scene.add(box).value();
    }
    for (int tick = 0; tick < 90; ++tick) {
        scene.step(1.0F / 30.0F);
    }
    return static_cast<double>(0.5F + static_cast<float>(bodies - 1) -
                               scene.state(top).position.y());
}

TEST(ErrorModels, SayWithinAFactorOfTwoHowFarAPileSinks) {
    for (const int bodies : {1, 2, 4, 8}) {
        for (const double budget : {0.02, 0.005, 0.001}) {
            const Pile pile{bodies, 9.81};
            const double tick_s = 1.0 / 30.0;
            const double expected =
                pile_sag_m(pile, substeps_for(budget, pile.load_mps2(), tick_s), tick_s);
            const double sag = simulated_sag_m(bodies, budget);
            EXPECT_LT(sag, 2.0 * expected) << bodies << " within " << budget;
            EXPECT_GT(sag, 0.5 * expected) << bodies << " within " << budget;
        }
    }
}

TEST(PassCosts, PriceEveryPassByItsUnits) {
    for (std::size_t p = 0; p < zone::kPasses; ++p) {
        const auto pass = static_cast<zone::Pass>(p);
        const PassCost& cost = cost_of(pass);
        EXPECT_EQ(cost.unit[0], "runs") << zone::pass_name(pass);
        PassUnits none{};
        EXPECT_EQ(table_ns(pass, none), 0.0);
        double sum = 0.0;
        for (std::size_t k = 0; k < kUnitKinds; ++k) {
            EXPECT_GE(cost.ns[k], 0.0);
            EXPECT_TRUE(!cost.unit[k].empty() || cost.ns[k] == 0.0) << zone::pass_name(pass);
            PassUnits one{};
            one[k] = 2.0;
            EXPECT_DOUBLE_EQ(table_ns(pass, one), 2.0 * cost.ns[k]);
            sum += cost.ns[k];
        }
        EXPECT_GT(sum, 0.0) << zone::pass_name(pass);
        const zone::StepReport idle;
        EXPECT_EQ(units_of(pass, idle), none);
    }
}

TEST(PassCosts, BelieveTheMachineTheMoreItHasRun) {
    EXPECT_EQ(expected_ns(100.0, 2.0, 0.0, 0.0), 200.0);
    EXPECT_EQ(expected_ns(100.0, 1.0, 300.0, kTableRuns), 200.0);
    EXPECT_NEAR(expected_ns(100.0, 1.0, 300.0, 1e6), 300.0, 0.01);
}

}  // namespace
}  // namespace zoned::config::test
