// The world config/methods/ai_code: guards by a switch, by objects and by data live alike in the
// running world, for any number of threads, and their code is asked for in reports.
#include "server/ai/agent/whereabouts.h"
#include "server/app/runtime/agent_report.h"
#include "server/app/world/agent_reload.h"
#include "server/app/world/world.h"
#include "server/app/world/world_rules.h"
#include "server/config/expand/load_settings.h"
#include "server/zone/zone_state.h"
#include "tests/harness/game_test.h"

#include <exception>
#include <map>
#include <memory>
#include <set>
#include <stdexcept>
#include <string>
#include <tuple>
#include <vector>

namespace zoned::harness {
namespace {

const std::string kGuards = ZONED_SOURCE_DIR "/config/methods/ai_code.txtpb";

/// An agent after a tick, to the last bit: state, time of its change, transition held, x and z. An
/// unseen agent is where its walk has led it; its entity is moved there at its events alone.
using Guarding = std::tuple<std::uint16_t, Tick, std::uint16_t, Tick, float, float>;
using GuardsByEntity = std::map<std::uint32_t, Guarding>;

GuardsByEntity guards_of(const app::World& now) {
    GuardsByEntity out;
    for (const auto& zone : now.zones()) {
        const zone::ZoneState& state = zone->state();
        for (std::size_t n = 0; n < state.agents.size(); ++n) {
            const ai::Agent& agent = state.agents.at(state.agents.nth(n));
            const ai::state_machine::ActiveState& active = agent.state_machine;
            const bool holds = active.pending != ai::state_machine::kNone;
            const Vec3& body = state.entities.position[state.entities.find(agent.entity)];
            const Vec2 at =
                ai::whereabouts(agent, Vec2(body.x(), body.z()), state.now + 1, state.settings.dt);
            out[agent.entity.value] = {active.leaf,
                                       active.since[0],
                                       active.pending,
                                       holds ? active.pending_since : 0,
                                       at.x(),
                                       at.y()};
        }
    }
    return out;
}

class CodedGuards : public GameTest {
  protected:
    CodedGuards() {
        server.config = kGuards;
        server.network.delay_s = 0.03;
        bots.bots = 12;
        bots.seconds = 40.0;
    }

    /// All guards by one brain, tick by tick.
    std::vector<GuardsByEntity> play(const std::string& brain) {
        server.sets = {"type[guard_by_switch].brain=" + brain,
                       "type[guard_by_states].brain=" + brain,
                       "type[guard_by_data].brain=" + brain};
        std::vector<GuardsByEntity> ticks;
        Tick last = 0;
        const measure::RunReport report = run([&](VirtualServer& now, double) {
            if (now.world().now() != last) {
                last = now.world().now();
                ticks.push_back(guards_of(now.world()));
            }
        });
        EXPECT_TRUE(report.consistent) << reasons(report);
        return ticks;
    }
};

/// The changes of state that some guard made, by states from and to.
std::set<std::pair<int, int>> changes_of(const std::vector<GuardsByEntity>& ticks) {
    std::set<std::pair<int, int>> changes;
    for (std::size_t t = 1; t < ticks.size(); ++t) {
        for (const auto& [entity, guard] : ticks[t]) {
            const auto before = ticks[t - 1].find(entity);
            if (before != ticks[t - 1].end() && std::get<0>(before->second) != std::get<0>(guard)) {
                changes.insert({std::get<0>(before->second), std::get<0>(guard)});
            }
        }
    }
    return changes;
}

TEST_F(CodedGuards, ChangeAtTheSameTicksAsThoseOfData) {
    const std::vector<GuardsByEntity> data = play("data");
    ASSERT_GT(data.size(), 1000U);
    ASSERT_EQ(data[0].size(), 24U);
    // Post to round and back, pursuit from both, out of it to rest and to the way back, from rest
    // to pursuit or to the way back, home.
    EXPECT_GE(changes_of(data).size(), 8U);
    for (const char* brain : {"switch", "states"}) {
        const std::vector<GuardsByEntity> code = play(brain);
        ASSERT_EQ(code.size(), data.size());
        for (std::size_t t = 0; t < data.size(); ++t) {
            ASSERT_EQ(code[t], data[t]) << brain << ", tick " << t;
        }
    }
}

TEST_F(CodedGuards, AreTheSameInASecondRunOnTwoThreads) {
    EXPECT_EQ(difference_between_runs(), "");
}

config::Settings guard_settings(const std::vector<std::string>& sets = {}) {
    config::Settings settings;
    std::vector<config::ConfigError> errors;
    EXPECT_TRUE(config::load_settings(kGuards, sets, settings, errors))
        << config::format_errors(kGuards, errors);
    return settings;
}

/// All guards by one brain.
config::Settings guards_by(const std::string& brain) {
    return guard_settings({"type[guard_by_switch].brain=" + brain,
                           "type[guard_by_states].brain=" + brain,
                           "type[guard_by_data].brain=" + brain});
}

/// Nobody is near, so all guards are off screen.
TEST(CodedGuardsWorld, IsTheSameForAnyNumberOfThreads) {
    const config::Settings settings = guard_settings();
    std::vector<std::vector<std::uint64_t>> hashes;
    std::vector<GuardsByEntity> ends;
    for (const unsigned threads : {1U, 2U, 4U}) {
        app::World world(settings, threads);
        std::vector<mailbox::OutboxItem> out;
        hashes.emplace_back();
        for (int tick = 0; tick < 900; ++tick) {
            world.tick({}, out);
            out.clear();
            hashes.back().push_back(world.state_hash());
        }
        ends.push_back(guards_of(world));
    }
    EXPECT_EQ(hashes[0], hashes[1]);
    EXPECT_EQ(hashes[0], hashes[2]);
    EXPECT_EQ(ends[0], ends[1]);
}

TEST(CodedGuardsWorld, TellsWhyByTheNamesOfItsCode) {
    const config::Settings settings = guard_settings();
    app::World world(settings, 1);
    std::vector<mailbox::OutboxItem> out;
    world.tick({}, out);
    bool named = false;
    for (const auto& zone : world.zones()) {
        zone::ZoneState& state = zone->state();
        for (std::size_t n = 0; n < state.agents.size(); ++n) {
            const EntityId entity = state.agents.at(state.agents.nth(n)).entity;
            named = named ||
                    app::agent_report(settings, *zone, entity, world.now())
                            .find(
                                "transitions by code gate_guard_states, which reads: "
                                "player distance, home distance, breath\n") != std::string::npos;
        }
    }
    EXPECT_TRUE(named);
}

std::string why_refused(const std::vector<std::string>& sets) {
    try {
        app::try_world_rules(guard_settings(sets));
    } catch (const std::exception& error) {
        return error.what();
    }
    return {};
}

TEST(CodedGuardsWorld, IsRefusedWhereConfigAndCodeDiffer) {
    EXPECT_EQ(why_refused({}), "");
    EXPECT_EQ(why_refused({"brain[switch].coded=gate_gard"}),
              "brain 'switch' names code 'gate_gard', which these rules do not have");
    EXPECT_EQ(why_refused({"brain[states].state[rest].name=sleep"}),
              "brain 'states' has no state named 'rest', which code 'gate_guard_states' uses");
    EXPECT_EQ(why_refused({"brain[data].coded=gate_guard",
                           "brain[data].state[post].transition=",
                           "brain[data].state[round].transition=",
                           "brain[data].state[pursuit].transition=",
                           "brain[data].state[rest].transition=",
                           "brain[data].state[way_back].transition="}),
              "");
    const config::Settings wrong = guard_settings({"brain[switch].coded=gate_gard"});
    EXPECT_THROW(app::World(wrong, 1), std::runtime_error);
    const config::Settings broken = guard_settings({"testing.break_zone.at_tick=100000"});
    EXPECT_NO_THROW(app::World(broken, 1)) << "rules with a fault on purpose have the same code";
}

/// As in a replay: brains read anew come as text.
mailbox::InboxItem reload_to(const config::Settings& running, const std::string& text) {
    mailbox::InboxItem item =
        mailbox::NewBrains{std::make_shared<const std::string>(text), nullptr};
    const auto restored = app::restore_brains(running, item);
    EXPECT_TRUE(restored.ok()) << restored.error();
    return item;
}

/// Both worlds read brains anew, which ends all holds; one of them goes over to code.
TEST(CodedGuardsWorld, GoesOverToCodeWhileItRuns) {
    const config::Settings data = guards_by("data");
    const config::Settings code = guards_by("states");
    app::World stays(data, 1);
    app::World changes(data, 1);
    std::vector<mailbox::OutboxItem> out;
    for (int tick = 0; tick < 1800; ++tick) {
        std::vector<mailbox::InboxItem> same;
        std::vector<mailbox::InboxItem> other;
        if (tick == 400) {
            same.push_back(reload_to(data, data.text));
            other.push_back(reload_to(data, code.text));
        }
        stays.tick(same, out);
        out.clear();
        changes.tick(other, out);
        out.clear();
        ASSERT_EQ(guards_of(stays), guards_of(changes)) << tick;
    }
    const zone::ZoneState& state = changes.zones()[0]->state();
    ASSERT_GT(state.agents.size(), 0U);
    const ai::Agent& agent = state.agents.at(state.agents.nth(0));
    EXPECT_TRUE(state.settings.ai.compiled[agent.brain].code);
}

TEST(CodedGuardsWorld, RefusesAReloadToCodeThatIsNotThere) {
    const config::Settings settings = guard_settings();
    mailbox::InboxItem item = mailbox::NewBrains{
        std::make_shared<const std::string>(guard_settings({"brain[switch].coded=gate_gard"}).text),
        nullptr};
    const auto restored = app::restore_brains(settings, item);
    ASSERT_FALSE(restored.ok());
    EXPECT_EQ(restored.error(),
              "brain 'switch' names code 'gate_gard', which these rules do not have");
}

}  // namespace
}  // namespace zoned::harness
