#include "server/ai/decision/goap/goap_planner.h"
#include "tests/scenario/gunman.h"
#include "tests/unit/allocation_count.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <limits>

namespace zoned::ai::goap::test {
namespace {

using scenario::fact;
using testing::ElementsAre;

std::vector<std::string> names(const Plan& plan, const Domain& domain) {
    std::vector<std::string> names;
    for (std::size_t k = 0; k < plan.size; ++k) {
        names.push_back(domain.actions[plan.action[k]].name);
    }
    return names;
}

Plan plan_for(const Domain& domain, FactSet from, std::uint32_t bound = 4096) {
    GoapPlanner planner(bound);
    Plan plan;
    planner.plan(Actions(domain), from, domain.goals[0].wants, plan);
    return plan;
}

constexpr std::uint32_t kNoPath = std::numeric_limits<std::uint32_t>::max();

/// Cost of the cheapest plan by relaxing all worlds until nothing changes: no search, no heuristic.
std::uint32_t brute_force(const Domain& domain, FactSet from) {
    const std::size_t worlds = std::size_t{1} << domain.facts.size();
    std::vector<std::uint32_t> cost(worlds, kNoPath);
    cost[from] = 0;
    for (bool changed = true; changed;) {
        changed = false;
        for (FactSet world = 0; world < worlds; ++world) {
            if (cost[world] == kNoPath) {
                continue;
            }
            for (const Action& action : domain.actions) {
                const FactSet to = after(action, world);
                if (action.needs.hold_in(world) && cost[world] + action.cost < cost[to]) {
                    cost[to] = cost[world] + action.cost;
                    changed = true;
                }
            }
        }
    }
    std::uint32_t best = kNoPath;
    for (FactSet world = 0; world < worlds; ++world) {
        if (domain.goals[0].wants.hold_in(world)) {
            best = std::min(best, cost[world]);
        }
    }
    return best;
}

/// Carries the plan out; false where a step's needs do not hold or the goal does not come true.
bool works(const Plan& plan, const Domain& domain, FactSet world) {
    std::uint32_t cost = 0;
    for (std::size_t k = 0; k < plan.size; ++k) {
        const Action& action = domain.actions[plan.action[k]];
        if (!action.needs.hold_in(world)) {
            return false;
        }
        world = after(action, world);
        cost += action.cost;
    }
    return cost == plan.cost && domain.goals[0].wants.hold_in(world);
}

TEST(GoapPlanner, FindsTheFourStepsOfTheGunman) {
    const Domain domain = scenario::gunman_domain();
    const Plan plan = plan_for(domain, scenario::kGunmanWorld);
    ASSERT_EQ(plan.verdict, Verdict::kPlanned);
    EXPECT_EQ(plan.cost, 4U);
    EXPECT_TRUE(works(plan, domain, scenario::kGunmanWorld));
    const auto steps = names(plan, domain);
    ASSERT_EQ(steps.size(), 4U);
    EXPECT_THAT((std::vector<std::string>{steps[0], steps[1]}),
                testing::UnorderedElementsAre("scout", "load"));
    EXPECT_EQ(steps[2], "aim");
    EXPECT_EQ(steps[3], "shoot");
}

TEST(GoapPlanner, PlansASuicideOnlyWhereLifeIsNotWanted) {
    Domain domain = scenario::gunman_domain();
    domain.actions[3].cost = 10;  // shooting is dear: the bomb would be cheaper
    EXPECT_THAT(names(plan_for(domain, scenario::kGunmanWorld), domain),
                testing::Contains("shoot"));
    domain.goals[0].wants.yes = 0;
    EXPECT_THAT(names(plan_for(domain, scenario::kGunmanWorld), domain),
                ElementsAre("scout", "approach", "detonate"));
}

TEST(GoapPlanner, HasNothingToDoWhereTheGoalHolds) {
    const Domain domain = scenario::gunman_domain();
    const Plan plan = plan_for(domain, fact(scenario::kAlive));
    EXPECT_EQ(plan.verdict, Verdict::kPlanned);
    EXPECT_EQ(plan.size, 0);
}

TEST(GoapPlanner, IsOptimalOnRandomDomains) {
    core::Rng rng(23);
    GoapPlanner planner(4096);
    int reachable = 0;
    int long_plans = 0;
    for (int trial = 0; trial < 20000; ++trial) {
        const Domain domain = scenario::random_domain(3 + rng.below(4), 4 + rng.below(10), rng);
        const FactSet from = rng.next() & domain.all_facts();
        const std::uint32_t best = brute_force(domain, from);
        Plan plan;
        planner.plan(Actions(domain), from, domain.goals[0].wants, plan);
        if (best == kNoPath) {
            ASSERT_EQ(plan.verdict, Verdict::kUnreachable) << trial;
            continue;
        }
        ASSERT_EQ(plan.verdict, Verdict::kPlanned) << trial;
        ASSERT_EQ(plan.cost, best) << trial;
        ASSERT_TRUE(works(plan, domain, from)) << trial;
        ++reachable;
        long_plans += plan.size >= 4 ? 1 : 0;
    }
    EXPECT_GT(reachable, 5000);
    EXPECT_GT(long_plans, 100) << "the domains are not all trivial";
}

TEST(GoapPlanner, RecognisesAnUnreachableGoalWithoutASearch) {
    const Plan plan = plan_for(scenario::unreachable_domain(), 0);
    EXPECT_EQ(plan.verdict, Verdict::kUnreachable);
    EXPECT_EQ(plan.created, 0U);
}

TEST(GoapPlanner, CanReachAllElseInThatDomain) {
    Domain domain = scenario::unreachable_domain();
    domain.goals[0].wants.yes &= ~fact(31);
    const Plan plan = plan_for(domain, 0, 65536);
    ASSERT_EQ(plan.verdict, Verdict::kPlanned);
    EXPECT_TRUE(works(plan, domain, 0));
}

/// Each of `n` facts must be made in its turn, and each action undoes the one before: as many steps
/// as a counter has states.
Domain counter(unsigned n) {
    Domain domain;
    for (unsigned f = 0; f < n; ++f) {
        domain.facts.push_back("bit" + std::to_string(f));
        Action action;
        action.name = "carry" + std::to_string(f);
        action.needs = {fact(f) - 1, fact(f)};  // all lower bits set, this one not
        action.makes = {fact(f), fact(f) - 1};
        domain.actions.push_back(action);
    }
    domain.goals = {{"full", {fact(n) - 1, 0}}};
    return domain;
}

TEST(GoapPlanner, CutsALongSearchOffAtItsBound) {
    // 2^12 - 1 steps would reach the goal; the plan may have 32.
    const Plan plan = plan_for(counter(12), 0, 500);
    EXPECT_EQ(plan.verdict, Verdict::kCutOff);
    EXPECT_LE(plan.created, 501U);
    const Plan five = plan_for(counter(5), 0, 500);
    EXPECT_EQ(five.verdict, Verdict::kPlanned);
    EXPECT_EQ(five.size, 31);
    // With six bits no bound on nodes is met, but that on steps is.
    EXPECT_EQ(plan_for(counter(6), 0, 65536).verdict, Verdict::kCutOff);
}

TEST(GoapPlanner, CutsOffAtEveryBoundInsteadOfFailing) {
    core::Rng rng(29);
    for (int trial = 0; trial < 300; ++trial) {
        const Domain domain = scenario::random_domain(6, 10, rng);
        const FactSet from = rng.next() & domain.all_facts();
        const std::uint32_t best = brute_force(domain, from);
        for (const std::uint32_t bound : {1U, 2U, 3U, 5U, 9U, 17U}) {
            const Plan plan = plan_for(domain, from, bound);
            ASSERT_LE(plan.created, bound + 1);
            if (plan.verdict == Verdict::kPlanned) {
                ASSERT_TRUE(works(plan, domain, from));
                ASSERT_EQ(plan.cost, best);
            } else if (plan.verdict == Verdict::kUnreachable) {
                ASSERT_EQ(best, kNoPath);
            }
        }
    }
}

TEST(GoapPlanner, RemembersNothingOfThePlanBefore) {
    core::Rng rng(31);
    GoapPlanner used(4096);
    for (int trial = 0; trial < 300; ++trial) {
        const Domain domain = scenario::random_domain(6, 9, rng);
        const FactSet from = rng.next() & domain.all_facts();
        Plan plan;
        used.plan(Actions(domain), from, domain.goals[0].wants, plan);
        const Plan fresh = plan_for(domain, from);
        ASSERT_EQ(plan.verdict, fresh.verdict);
        ASSERT_EQ(names(plan, domain), names(fresh, domain));
        ASSERT_EQ(plan.created, fresh.created);
    }
}

TEST(GoapPlanner, AllocatesNothing) {
    core::Rng rng(37);
    std::vector<Domain> domains;
    std::vector<Actions> actions;
    for (int d = 0; d < 50; ++d) {
        domains.push_back(scenario::random_domain(8, 20, rng));
        actions.emplace_back(domains.back());
    }
    GoapPlanner planner(512);
    Plan plan;
    const std::uint64_t before = allocation_count();
    for (int trial = 0; trial < 2000; ++trial) {
        const std::size_t d = rng.below(50);
        planner.plan(actions[d], rng.next() & 0xFF, domains[d].goals[0].wants, plan);
    }
    EXPECT_EQ(allocation_count(), before);
}

// ---------------------------------------------------------------- definitions

std::vector<GoapDefectKind> kinds(const Domain& domain) {
    std::vector<GoapDefectKind> kinds;
    for (const GoapDefect& defect : defects_of(domain)) {
        kinds.push_back(defect.kind);
    }
    return kinds;
}

TEST(DomainDefects, AreNoneForTheGunmanButHisFlight) {
    // No action ever needs the foe to be far.
    const Domain domain = scenario::gunman_domain();
    const auto defects = defects_of(domain);
    ASSERT_EQ(defects.size(), 1U);
    EXPECT_EQ(defects[0].kind, GoapDefectKind::kNeverWanted);
    EXPECT_EQ(domain.actions[static_cast<std::size_t>(defects[0].action)].name, "flee");
}

TEST(DomainDefects, AreEachFound) {
    Domain domain;
    domain.facts = {"a", "b"};
    domain.actions = {{"make", {1, 0}, {2, 0}, 1}};
    domain.goals = {{"b", {2, 0}}};
    EXPECT_TRUE(kinds(domain).empty());
    domain.actions[0].makes = {1, 0};
    EXPECT_THAT(kinds(domain),
                ElementsAre(GoapDefectKind::kNoEffect, GoapDefectKind::kNothingMakesIt));
    domain.actions[0].makes = {2, 2};
    EXPECT_THAT(kinds(domain), testing::Contains(GoapDefectKind::kContradiction));
    domain.actions[0].makes = {2 | 4, 0};
    EXPECT_THAT(kinds(domain), ElementsAre(GoapDefectKind::kUnknownFact));
    domain.actions[0].makes = {2, 0};
    domain.actions[0].cost = 0;
    EXPECT_THAT(kinds(domain), ElementsAre(GoapDefectKind::kBadCost));
    domain.actions[0].cost = 1;
    domain.facts.resize(65);
    EXPECT_THAT(kinds(domain), ElementsAre(GoapDefectKind::kTooManyFacts));
}

}  // namespace
}  // namespace zoned::ai::goap::test
