// Calls between rules and their zone: the first tick, timers, messages between zones, names,
// agents.
#include "server/ai/agent/whereabouts.h"
#include "server/zone/context/zone_context.h"
#include "tests/integration/plain/crowd_world.h"
#include "tests/integration/plain/plain_log.h"

#include <cmath>
#include <functional>
#include <limits>
#include <map>
#include <memory>

namespace zoned::app {
namespace {

using test::Crowd;

constexpr double kTick_s = 0.05;

constexpr const char* kCallsWorld = R"(
world { name: "calls" seed: 5 tick_rate_hz: 20 min_x_m: -200 min_z_m: -50 max_x_m: 200 max_z_m: 50 }
zones { zone_grid { columns: 2 rows: 1 } }
type { name: "player" kind: CHARACTER capsule { radius_m: 0.4 length_m: 1 } aura_m { normal: 50 } nimbus_m { normal: 50 } character { } }
type { name: "ball" sphere { radius_m: 0.2 } mass_kg: 2 aura_m { normal: 50 } }
type { name: "guard" kind: CHARACTER capsule { radius_m: 0.4 length_m: 1 } aura_m { normal: 50 } character { speed_mps: 3 } brain: "guard" }
brain {
  name: "guard" variable { name: "alarm" high: 5 }
  state { name: "stand" action: IDLE transition { to: "walk" sense: "alarm" compare: ABOVE threshold: 2 } }
  state { name: "walk" action: RETURN }
}
entity { type: "ball" name: "bell" x_m: -2 z_m: 0 asleep: true }
entity { type: "guard" name: "sentry" x_m: 100 z_m: 0 }
spawn { x_m: 0 z_m: 40 }
lod { position_bound_m: 0.5 orientation_bound_rad: 0.3 }
session { dev_mode_loopback: true }
)";

class RulesCalls : public ::testing::Test {
  protected:
    RulesCalls() { plain_log() = std::make_shared<scenario::PlainLog>(); }

    ~RulesCalls() override { plain_log() = std::make_shared<scenario::PlainLog>(); }

    /// In the given zone, in its first tick.
    void at_start(std::uint16_t zone, const std::function<void(zone::RulesContext&)>& call) {
        plain_log()->at_start = [=](zone::RulesContext& context) {
            if (context.zone() == ZoneId(zone)) {
                call(context);
            }
        };
        world = std::make_unique<Crowd>(kCallsWorld);
        world->tick();
        plain_log()->at_start = {};
    }

    void ticks(int count) {
        for (int i = 0; i < count; ++i) {
            world->tick();
        }
    }

    /// A call outside of the zone's step, as rules would make it.
    [[nodiscard]] zone::ZoneContext context(std::size_t zone) {
        return zone::ZoneContext(world->world().zones()[zone]->state());
    }

    [[nodiscard]] static std::vector<std::uint16_t> kinds() {
        std::vector<std::uint16_t> all;
        for (const auto& [zone, timer] : plain_log()->timers) {
            all.push_back(timer.kind);
        }
        return all;
    }

    std::unique_ptr<Crowd> world;
};

TEST_F(RulesCalls, EachZoneStartsOnceInItsFirstTick) {
    at_start(1, [](zone::RulesContext&) {});
    ticks(5);
    const auto& starts = plain_log()->starts;
    ASSERT_EQ(starts.size(), 2u);
    EXPECT_NE(starts[0].first, starts[1].first);
    EXPECT_EQ(starts[0].second, starts[1].second);
    EXPECT_EQ(starts[0].second, world->world().zones()[0]->state().now - 5);
}

TEST_F(RulesCalls, TimersAreDueInTheirTickWhereNobodyPlaysAndNothingRunsBefore) {
    at_start(1, [](zone::RulesContext& c) {
        c.start_timer(EntityId(), 10 * kTick_s, 7, {1, 2});
        c.start_timer(EntityId(), 5 * kTick_s, 6);
        c.start_timer(EntityId(), 10 * kTick_s, 8);
        c.start_timer(EntityId(), 0.0, 5);
    });
    const zone::ZoneState& state = world->world().zones()[0]->state();
    const auto rules_ran = [&] {
        return state.report.passes[static_cast<std::size_t>(zone::Pass::kRules)].ran;
    };
    ticks(1);
    EXPECT_EQ(kinds(), (std::vector<std::uint16_t>{5}));
    ticks(3);
    EXPECT_FALSE(rules_ran());
    ticks(1);
    EXPECT_TRUE(rules_ran());
    EXPECT_EQ(kinds(), (std::vector<std::uint16_t>{5, 6}));
    ticks(5);
    EXPECT_EQ(kinds(), (std::vector<std::uint16_t>{5, 6, 7, 8}));
    EXPECT_EQ(plain_log()->timers[2].second.payload, (zone::Bytes{1, 2}));
    EXPECT_TRUE(state.timers.empty());
    ticks(1);
    EXPECT_FALSE(rules_ran());
}

TEST_F(RulesCalls, TimersThatCannotBeAreNotStarted) {
    at_start(1, [](zone::RulesContext& c) {
        const double none = std::numeric_limits<double>::quiet_NaN();
        const double never = std::numeric_limits<double>::infinity();
        for (const double seconds : {-1.0, none, never, 1e300}) {
            EXPECT_FALSE(c.start_timer(EntityId(), seconds, 1)) << seconds;
        }
        EXPECT_FALSE(c.start_timer(EntityId(12345), 1.0, 1));
        EXPECT_FALSE(c.start_timer(c.entity_named("sentry"), 1.0, 1)) << "of another zone";
        for (std::size_t i = 0; i < zone::kMostTimers; ++i) {
            ASSERT_TRUE(c.start_timer(EntityId(), 1e6, 1));
        }
        EXPECT_FALSE(c.start_timer(EntityId(), 1.0, 1));
    });
}

TEST_F(RulesCalls, StoppedTimersAndThoseOfTheDeadAreNotDue) {
    at_start(1, [](zone::RulesContext& c) {
        const EntityId bell = c.entity_named("bell");
        c.start_timer(bell, 4 * kTick_s, 1);
        const zone::TimerId stopped = c.start_timer(EntityId(), 2 * kTick_s, 2);
        c.start_timer(EntityId(), 3 * kTick_s, 3);
        c.stop_timer(stopped);
        c.stop_timer(zone::TimerId(987));
        c.despawn(bell);
    });
    ticks(10);
    EXPECT_EQ(kinds(), (std::vector<std::uint16_t>{3}));
}

TEST_F(RulesCalls, TimersGoAlongToAnotherZone) {
    at_start(1, [](zone::RulesContext& c) {
        const EntityId bell = c.entity_named("bell");
        c.start_timer(bell, 60 * kTick_s, 4);
        c.start_timer(EntityId(), 60 * kTick_s, 5);
        c.add_velocity(bell, Vec3(8.0F, 3.0F, 0.0F));
    });
    ticks(59);
    const EntityId bell = context(0).entity_named("bell");
    ASSERT_TRUE(world->world().zones()[1]->owns(bell)) << "the ball did not cross the border";
    EXPECT_EQ(kinds(), (std::vector<std::uint16_t>{}));
    ticks(1);
    ASSERT_EQ(plain_log()->timers.size(), 2u);
    for (const auto& [zone, timer] : plain_log()->timers) {
        EXPECT_EQ(zone, ZoneId(timer.kind == 4 ? 2 : 1));
        EXPECT_EQ(timer.entity, timer.kind == 4 ? bell : EntityId());
    }
}

TEST_F(RulesCalls, JointsHaveAnEnd) {
    at_start(1, [](zone::RulesContext& c) {
        const EntityId bell = c.entity_named("bell");
        const zone::EntityJointId first = c.add_joint(EntityId(), bell, {});
        for (std::size_t i = 1; i < zone::kMostJoints; ++i) {
            ASSERT_TRUE(c.add_joint(EntityId(), bell, {}));
        }
        EXPECT_FALSE(c.add_joint(EntityId(), bell, {}));
        c.remove_joint(first);
        EXPECT_TRUE(c.add_joint(EntityId(), bell, {}));
        c.despawn(bell);
    });
}

TEST_F(RulesCalls, MessagesReachZones) {
    at_start(2, [](zone::RulesContext& c) {
        c.message_zone(ZoneId(1), {1});
        c.message_zone(ZoneId(), {0});
        c.message_zone(ZoneId(9), {9});
        c.message(EntityId(), {8});  // nobody is no zone
    });
    ticks(1);
    std::map<std::uint8_t, int> times;
    for (const auto& [target, payload] : plain_log()->messages) {
        EXPECT_FALSE(target);
        ++times[payload.at(0)];
    }
    EXPECT_EQ(times, (std::map<std::uint8_t, int>{{0, 2}, {1, 1}}));
    EXPECT_EQ(world->world().undeliverable(), 2u);
}

TEST_F(RulesCalls, LinesAndFiguresAreOfOneTickAndHaveAnEnd) {
    at_start(1, [](zone::RulesContext& c) {
        for (int i = 0; i < 150; ++i) {
            c.log(std::string(2000, 'x'));
        }
        c.count("kills", 2.0);
        c.gauge("open", 0.5);
    });
    const zone::StepOutput& out = world->world().zones()[0]->state().out;
    ASSERT_EQ(out.lines.size(), zone::kMostLogLines);
    EXPECT_EQ(out.lines[0].size(), zone::kMostLogBytes);
    ASSERT_EQ(out.figures.size(), 2u);
    EXPECT_TRUE(out.figures[0].counts);
    EXPECT_FALSE(out.figures[1].counts);
    EXPECT_EQ(out.figures[1].value, 0.5);
    ticks(1);
    EXPECT_TRUE(out.lines.empty() && out.figures.empty());
}

TEST_F(RulesCalls, NamesOfTheConfigAreKnownInAllZones) {
    at_start(1, [](zone::RulesContext&) {});
    for (std::size_t zone = 0; zone < 2; ++zone) {
        for (const char* name : {"bell", "sentry"}) {
            const EntityId entity = context(zone).entity_named(name);
            ASSERT_TRUE(entity);
            EXPECT_TRUE(world->world().zones()[name == std::string("bell") ? 0 : 1]->owns(entity));
        }
        EXPECT_FALSE(context(zone).entity_named("nobody"));
    }
}

TEST_F(RulesCalls, AgentsThatNobodySeesObeyAndTellWhatTheyDo) {
    at_start(1, [](zone::RulesContext&) {});
    ticks(200);
    zone::ZoneContext here = context(1);
    const EntityId sentry = here.entity_named("sentry");
    EXPECT_TRUE(world->world().zones()[1]->state().agents.active().empty()) << "it is off screen";
    ASSERT_TRUE(here.agent(sentry));
    EXPECT_EQ(here.agent(sentry)->brain, "guard");
    EXPECT_EQ(here.agent(sentry)->state, "stand");
    EXPECT_EQ(here.agent_variable(sentry, "alarm"), 0.0);
    EXPECT_FALSE(here.agent_variable(sentry, "joy"));
    EXPECT_FALSE(here.set_agent_variable(sentry, "joy", 1.0));
    EXPECT_FALSE(here.set_agent_variable(sentry, "alarm", std::nan("")));
    EXPECT_FALSE(here.set_agent_variable(here.entity_named("bell"), "alarm", 1.0));
    EXPECT_FALSE(context(0).set_agent_variable(sentry, "alarm", 3.0)) << "of another zone";
    const Vec3 start = here.entities().position[here.entities().find(sentry)];
    const Vec3 post = start + Vec3(9.0F, 0.0F, 0.0F);
    EXPECT_TRUE(here.set_agent_home(sentry, post));
    EXPECT_TRUE(here.set_agent_variable(sentry, "alarm", 7.0));
    EXPECT_EQ(here.agent_variable(sentry, "alarm"), 5.0) << "the most that it can be";
    ticks(1);
    EXPECT_EQ(here.agent(sentry)->state, "walk");
    EXPECT_EQ(here.agent(sentry)->home, post);
    ticks(100);  // 9 m at 3 m/s, and as long again
    // It may be off screen again by now, where its place is known by its timetable.
    const ai::Agent& agent = *world->world().zones()[1]->state().agents.find(sentry);
    const Vec3& body = here.entities().position[here.entities().find(sentry)];
    const Vec2 at = ai::whereabouts(
        agent, Vec2(body.x(), body.z()), here.now() + 1, static_cast<float>(kTick_s));
    EXPECT_LT((at - Vec2(post.x(), post.z())).norm(), 1.5F);
}

}  // namespace
}  // namespace zoned::app
