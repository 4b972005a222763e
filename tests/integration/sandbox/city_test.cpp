// The world `city` with bots: crowds avoid each other, soldiers keep their rows, and a herd follows
// its path. The bots' views of it are right.
#include "server/app/world/world.h"
#include "server/zone/zone_state.h"
#include "tests/harness/game_test.h"

#include <algorithm>

namespace zoned::harness {
namespace {

/// Observations of the crowd.
struct CityWatch {
    std::uint64_t crowded = 0;
    std::uint64_t gave_way = 0;
    std::uint64_t active = 0;
    std::uint64_t suspended = 0;
    std::uint32_t marching = 0;  ///< the most soldiers with a slot at a time
    std::uint32_t drifting = 0;  ///< sheep active

    void look(app::World& world) {
        std::uint32_t in_rank = 0;
        std::uint32_t sheep = 0;
        for (const auto& zone : world.zones()) {
            const zone::ZoneState& state = zone->state();
            const ai::AiReport& report = zone->report().ai;
            crowded += report.avoidance.crowded;
            gave_way += report.avoidance.gave_way;
            active += report.active;
            suspended += report.agents - report.active;
            for (const ai::Slot slot : state.agents.active()) {
                const ai::Agent& agent = state.agents.at(slot);
                const ai::CompiledBrain& brain = state.settings.ai.compiled[agent.brain];
                const ai::ActionKind action = brain.states[agent.current_action].action;
                in_rank +=
                    action == ai::ActionKind::kFormUp && (agent.corner & 0x7F) < 16 ? 1U : 0U;
                sheep += action == ai::ActionKind::kFlock ? 1U : 0U;
            }
        }
        marching = std::max(marching, in_rank);
        drifting = std::max(drifting, sheep);
    }
};

TEST_F(GameTest, ACityWhosePeopleMakeWayForEachOtherIsConsistent) {
    server.config = ZONED_SOURCE_DIR "/config/city.txtpb";
    server.sets = {"ai.dawn_s=15"};  // when they set out
    server.network.delay_s = 0.03;
    server.network.jitter_s = 0.01;
    bots.bots = 10;
    bots.seconds = 30.0;
    CityWatch watch;
    const measure::RunReport report =
        run([&](VirtualServer& now, double) { watch.look(now.world()); });
    EXPECT_TRUE(report.consistent) << reasons(report);
    EXPECT_GT(watch.suspended, watch.active / 2) << "many are seen by nobody";
    EXPECT_GT(watch.crowded, 1000U);
    EXPECT_GT(watch.gave_way, 500U);
    EXPECT_EQ(watch.marching, 16U);
    EXPECT_GT(watch.drifting, 10U) << "somebody looks at the herd";
}

}  // namespace
}  // namespace zoned::harness
