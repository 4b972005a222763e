// A reload: what changes live, what waits for a restart, and that it is one whole.
#include "server/config/expand/reload_plan.h"

#include "tests/unit/config/config_helpers.h"

#include <gmock/gmock.h>

#include <algorithm>

namespace zoned::config::test {
namespace {

using ::testing::HasSubstr;
using ::testing::IsEmpty;

ReloadPlan plan_of(const std::string& before, const std::string& after) {
    const Outcome running = parse(before);
    const Outcome fresh = parse(after);
    EXPECT_TRUE(running.ok) << format_errors("running", running.errors);
    EXPECT_TRUE(fresh.ok) << format_errors("fresh", fresh.errors);
    auto plan = plan_reload(running.settings, fresh.settings);
    EXPECT_TRUE(plan.ok()) << plan.error();
    return plan.ok() ? *plan : ReloadPlan();
}

const SettingChange* find_change(const ReloadPlan& plan, const std::string& path) {
    const auto at = std::find_if(plan.changes.begin(), plan.changes.end(), [&](const auto& change) {
        return change.path == path;
    });
    return at == plan.changes.end() ? nullptr : &*at;
}

TEST(ReloadPlan, IsEmptyWhereNothingDiffers) {
    const ReloadPlan plan = plan_of(kValid, with("spawn {", "# a remark\nspawn {"));
    EXPECT_THAT(plan.changes, IsEmpty());
    EXPECT_EQ(plan.merged, nullptr);
    EXPECT_EQ(plan.brains, nullptr);
    // A default that is written down is no change.
    EXPECT_THAT(plan_of(kValid, kValid + "run { max_catch_up_ticks: 3 }\n").changes, IsEmpty());
}

TEST(ReloadPlan, TakesLimitsOfTheServerWithoutTouchingTheWorld) {
    const ReloadPlan plan =
        plan_of(kValid,
                with("dev_mode_loopback: true",
                     "dev_mode_loopback: true\ngrace_s: 5\ndev_rights: PLAY\ndev_rights: AUDIT") +
                    "log { level { area: \"session\" level: LEVEL_ERROR } }\n");
    const SettingChange* grace = find_change(plan, "session.grace_s");
    ASSERT_NE(grace, nullptr);
    EXPECT_EQ(grace->before, "30");
    EXPECT_EQ(grace->after, "5");
    EXPECT_TRUE(grace->live);
    ASSERT_NE(plan.merged, nullptr);
    EXPECT_EQ(plan.merged->server.session.grace_s, 5.0);
    EXPECT_EQ(plan.merged->server.session.dev_rights, 3U);
    EXPECT_EQ(plan.merged->server.log.levels[static_cast<std::size_t>(LogArea::kSession)],
              LogLevel::kError);
    EXPECT_EQ(plan.brains, nullptr) << "agents that stay need no migration";
}

TEST(ReloadPlan, TakesBrainsAndLeavesTheRestForARestart) {
    const ReloadPlan plan = plan_of(
        kValid, with("threshold: 20", "threshold: 30", with("x_m: 1 z_m: 2", "x_m: 3 z_m: 2")));
    ASSERT_EQ(plan.changes.size(), 2U);
    const SettingChange* spawn = find_change(plan, "spawn[0].x_m");
    ASSERT_NE(spawn, nullptr);
    EXPECT_FALSE(spawn->live);
    EXPECT_TRUE(find_change(plan, "brain[0].state[0].transition[0].threshold")->live);
    ASSERT_NE(plan.brains, nullptr);
    EXPECT_EQ(plan.brains->brains[0].states[0].transitions[0].threshold, 30.0F);
    // The settings that run are without what waits.
    ASSERT_NE(plan.merged, nullptr);
    EXPECT_EQ(plan.merged->spawn_points[0].position.x(), 1.0);
}

TEST(ReloadPlan, NamesEntriesThatCameOrWent) {
    const ReloadPlan plan = plan_of(kValid, kValid + "spawn { x_m: 5 z_m: 5 }\n");
    ASSERT_EQ(plan.changes.size(), 1U);
    EXPECT_EQ(plan.changes[0].path, "spawn");
    EXPECT_EQ(plan.changes[0].before, "1 entry");
    EXPECT_EQ(plan.changes[0].after, "2 entries");
    EXPECT_EQ(plan.merged, nullptr);
}

TEST(ReloadPlan, HoldsBrainsBackWhereTheTypesChanged) {
    const std::string more =
        "type { name: \"rock\" box { x_m: 1 y_m: 1 z_m: 1 } aura_m { normal: 9 } }\n";
    const ReloadPlan plan = plan_of(kValid, with("threshold: 20", "threshold: 30") + more);
    const SettingChange* brain = find_change(plan, "brain[0].state[0].transition[0].threshold");
    ASSERT_NE(brain, nullptr);
    EXPECT_FALSE(brain->live);
    EXPECT_THAT(brain->note, HasSubstr("types changed"));
    EXPECT_EQ(plan.brains, nullptr);
}

TEST(ReloadPlan, HoldsBackMoreClientsThanTheSocketsWereMadeFor) {
    const Outcome running = parse(kValid + "network { max_clients: 100 }\n");
    const Outcome fewer = parse(kValid + "network { max_clients: 10 }\n");
    const auto down = plan_reload(running.settings, fewer.settings);
    ASSERT_TRUE(down.ok());
    ASSERT_NE(down->merged, nullptr);
    EXPECT_EQ(down->merged->server.network.max_clients, 10U);
    // And back up to what it was started with, but not beyond.
    const auto back = plan_reload(*down->merged, running.settings);
    ASSERT_TRUE(back.ok());
    EXPECT_TRUE(back->changes[0].live);
    const Outcome more = parse(kValid + "network { max_clients: 101 }\n");
    const auto up = plan_reload(*down->merged, more.settings);
    ASSERT_TRUE(up.ok());
    EXPECT_FALSE(up->changes[0].live);
    EXPECT_THAT(up->changes[0].note, HasSubstr("at most 100"));
}

TEST(ReloadPlan, IsNothingWhereTheLivePartAloneIsNoGoodConfig) {
    const Outcome running = parse(kValid);
    // The brain asks for a stance that only the new config has.
    const Outcome fresh =
        parse(with("state { name: \"chase\" action: CHASE }",
                   "state { name: \"chase\" action: CHASE named_stance: \"flying\" }") +
              "stance: \"flying\"\n");
    ASSERT_TRUE(fresh.ok) << format_errors("fresh", fresh.errors);
    const auto plan = plan_reload(running.settings, fresh.settings);
    ASSERT_FALSE(plan.ok());
    EXPECT_THAT(plan.error(), HasSubstr("flying"));
}

}  // namespace
}  // namespace zoned::config::test
