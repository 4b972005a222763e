// Difficulty in zones: each zone follows the players in it, and agents that come over take the new
// zone's. All of it is the same for any number of threads.
#include "server/app/log/difficulty_log.h"
#include "tests/integration/plain/crowd_world.h"
#include "tests/integration/plain/plain_log.h"
#include "tests/scenario/log_text.h"

#include <optional>
#include <set>

namespace zoned::app {
namespace {

using test::Crowd;

/// Two zones. Walkers go from place to place over the border at a pace set by the difficulty; sheep
/// stand about. All agents are simulated, and only walkers are near anyone.
std::string two_zones(int walkers) {
    return R"(
world { name: "pilgrims" seed: 5 tick_rate_hz: 20 min_x_m: -100 min_z_m: -50 max_x_m: 100 max_z_m: 50 }
zones { zone_grid { columns: 2 rows: 1 } ghost_margin_m: 40 }
replication { silence_ticks: 10 }
ai {
  adaptation { difficulty: "slow" difficulty: "usual" difficulty: "fast" step: 1 success: 0.5 start: "usual" least_between_s: 1 }
}
type { name: "player" kind: CHARACTER capsule { radius_m: 0.4 length_m: 1 } aura_m { normal: 30 } nimbus_m { normal: 30 } character { } }
type { name: "pilgrim" kind: CHARACTER capsule { radius_m: 0.4 length_m: 1 } aura_m { normal: 30 } character { speed_mps: 4 } behaviour { name: "pilgrimage" } }
type { name: "sheep" kind: CHARACTER capsule { radius_m: 0.4 length_m: 0.3 } aura_m { normal: 30 } character { } brain: "stand" }
point_of_interest { name: "west" x_m: -60 z_m: 0 radius_m: 4 }
point_of_interest { name: "east" x_m: 60 z_m: 0 radius_m: 4 }
brain { name: "stand" state { name: "stand" action: IDLE } }
brain {
  name: "round"
  state { name: "there" action: GO point_of_interest: "east" speed_factor_from: "haste" transition { to: "back" sense: "east.distance" compare: BELOW threshold: 6 } }
  state { name: "back" action: GO point_of_interest: "west" speed_factor_from: "haste" transition { to: "there" sense: "west.distance" compare: BELOW threshold: 6 } }
}
behaviour { name: "pilgrimage" brain: "round" parameter { name: "haste" value: 0.5 low: 0.1 high: 1 } }
difficulty { name: "slow" set { name: "haste" factor: 0.5 } }
difficulty { name: "usual" set { name: "haste" factor: 1 } }
difficulty { name: "fast" set { name: "haste" factor: 2 } }
spawn { x_m: 0 z_m: 49 }
lod { position_bound_m: 0.5 orientation_bound_rad: 0.3 }
session { dev_mode_loopback: true }
scatter { type: "sheep" count: 6 seed: 3 min_distance_m: 5 region { min_x_m: -90 max_x_m: 90 min_z_m: 30 max_z_m: 45 } }
)" + std::string("scatter { type: \"pilgrim\" count: ") +
           std::to_string(walkers) +
           " seed: 2 min_distance_m: 2 region { min_x_m: -90 max_x_m: -20 min_z_m: -20 max_z_m: 20 "
           "} }\n";
}

/// The test decides the players' success: in the western zone they win, in the eastern they lose.
struct Outcomes {
    Outcomes() {
        plain_log() = std::make_shared<scenario::PlainLog>();
        plain_log()->busy = true;
        plain_log()->each_tick = [](zone::RulesContext& context) {
            if (context.now() == 30 || context.now() == 31) {
                context.note_outcome(context.zone() == ZoneId(1));
                context.note_outcome(context.zone() == ZoneId(1));
            }
        };
    }

    ~Outcomes() { plain_log() = std::make_shared<scenario::PlainLog>(); }

    Outcomes(const Outcomes&) = delete;
    Outcomes& operator=(const Outcomes&) = delete;
};

zone::ZoneState& zone_of(Crowd& crowd, std::size_t index) {
    return crowd.world().zones()[index]->state();
}

/// The pace of all pilgrims of a zone is that of its difficulty. `before` holds those that were
/// there a second ago; a pilgrim that has just arrived is still slowing down.
void expect_pace(Crowd& crowd, std::size_t index, float haste, std::set<EntityId>& before) {
    zone::ZoneState& state = zone_of(crowd, index);
    std::set<EntityId> here;
    for (std::size_t n = 0; n < state.agents.size(); ++n) {
        const ai::Agent& agent = state.agents.at(state.agents.nth(n));
        const world::Row row = state.entities.find(agent.entity);
        if ((*state.settings.types)[state.entities.type[row]].name != "pilgrim") {
            continue;
        }
        here.insert(agent.entity);
        EXPECT_EQ(state.settings.ai.compiled[agent.brain].states[agent.current_action].speed_factor,
                  haste);
        // A walking pilgrim has that share of 4 m/s; one that turns at an end is slower.
        if (before.contains(agent.entity)) {
            EXPECT_LT(state.entities.velocity[row].norm(), 4.0F * haste * 1.02F)
                << "entity " << agent.entity.value;
        }
    }
    before = std::move(here);
}

TEST(AdaptationInZones, FollowsThePlayersOfEachZoneAndAgentsTakeThatOfTheNext) {
    const Outcomes outcomes;
    const scenario::LogText log;
    Crowd crowd(two_zones(12));
    std::optional<ai::LevelChange> west;
    std::optional<ai::LevelChange> east;
    for (int t = 0; t < 20 * 3; ++t) {
        crowd.tick();
        const auto& zones = crowd.world().zones();
        west = zones[0]->report().level_change ? zones[0]->report().level_change : west;
        east = zones[1]->report().level_change ? zones[1]->report().level_change : east;
        log_difficulty(*zones[0]);
        log_difficulty(*zones[1]);
    }
    ASSERT_TRUE(west && east);
    EXPECT_NE(log.text().find("zone 1: difficulty usual -> fast at tick 30: 2 successes and 0 "
                              "failures of players at usual, level 2.00"),
              std::string::npos)
        << log.text();
    EXPECT_NE(log.text().find("zone 2: difficulty usual -> slow at tick 30"), std::string::npos);
    EXPECT_EQ(west->from, 1);
    EXPECT_EQ(west->to, 2);
    EXPECT_EQ(west->successes, 2U);
    EXPECT_EQ(west->failures, 0U);
    EXPECT_EQ(east->to, 0);
    EXPECT_EQ(east->failures, 2U);
    std::set<EntityId> in_west;
    std::set<EntityId> in_east;
    std::set<EntityId> came;
    std::set<EntityId> returned;
    for (int t = 0; t < 20 * 240; ++t) {
        crowd.tick();
        if (t % 20 == 0 && t > 100) {
            expect_pace(crowd, 0, 1.0F, in_west);
            expect_pace(crowd, 1, 0.25F, in_east);
        }
        for (std::size_t n = 0; n < zone_of(crowd, 1).agents.size(); ++n) {
            came.insert(zone_of(crowd, 1).agents.at(zone_of(crowd, 1).agents.nth(n)).entity);
        }
        for (std::size_t n = 0; n < zone_of(crowd, 0).agents.size(); ++n) {
            const EntityId id = zone_of(crowd, 0).agents.at(zone_of(crowd, 0).agents.nth(n)).entity;
            if (came.contains(id)) {
                returned.insert(id);
            }
        }
    }
    EXPECT_GE(came.size(), 12U);
    EXPECT_GE(returned.size(), 12U);
}

TEST(AdaptationInZones, GivesTheSameHashForOneAndFourThreads) {
    const Outcomes outcomes;
    Crowd one(two_zones(300), 1U);
    Crowd four(two_zones(300), 4U);
    plain_log()->each_tick = nullptr;
    Crowd still(two_zones(300), 1U);
    bool differs = false;
    for (int t = 0; t < 20 * 20; ++t) {
        plain_log()->each_tick = [](zone::RulesContext& context) {
            if (context.now() % 20 == 0) {
                context.note_outcome(context.zone() == ZoneId(1));
            }
        };
        one.tick();
        four.tick();
        plain_log()->each_tick = nullptr;
        still.tick();
        ASSERT_EQ(one.world().state_hash(), four.world().state_hash()) << "tick " << t;
        differs = differs || one.world().state_hash() != still.world().state_hash();
    }
    EXPECT_EQ(zone_of(one, 0).ai_update.difficulty().level, 2);
    EXPECT_EQ(zone_of(one, 1).ai_update.difficulty().level, 0);
    EXPECT_TRUE(differs) << "the hash knows of the difficulty";
}

}  // namespace
}  // namespace zoned::app
