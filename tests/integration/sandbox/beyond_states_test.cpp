// Things outside of the space that states can tell are in no view; they come back to views with
// their return.
#include "server/app/world/world.h"
#include "tests/harness/game_test.h"

#include <gtest/gtest.h>

namespace zoned::app {
namespace {

TEST_F(GameTest, AThingThatFliesHigherThanStatesCanTellIsNotSeenUntilItIsBack) {
    // 60 m/s lift it to 183 m, and it falls for as long again: 12 s in all, 5 s of them above 150
    // m.
    constexpr float kUp_mps = 60.0F;
    server.sets = {"replication.quantization.vertical_extent_m=150",
                   "type[crate].max_velocity_jump_mps=130"};
    server.network.loss = 0.05;
    bots.seconds = 16.0;
    bots.audit_every_s = 0.1;
    std::size_t ticks_beyond = 0;
    Tick last = 0;
    EntityId thrown;
    const auto report = run([&](harness::VirtualServer& running, double) {
        zone::ZoneState& state = running.world().zones().front()->state();
        world::Entities& e = state.entities;
        if (running.simulated() == last) {
            return;
        }
        last = running.simulated();
        if (!thrown && last > 60) {
            for (world::Row row = 0; row < e.size() && !thrown; ++row) {
                if (state.scene.contains(e.body[row]) && !e.client[row] &&
                    state.settings.types->at(e.type[row]).name == "crate") {
                    thrown = e.id[row];
                    state.scene.set_velocity(e.body[row], Vec3(0.0F, kUp_mps, 0.0F), Vec3::Zero());
                }
            }
        }
        const world::Row row = thrown ? e.find(thrown) : world::kNoRow;
        ticks_beyond += row != world::kNoRow && e.has(row, world::kBeyond) ? 1 : 0;
    });
    EXPECT_TRUE(report.consistent) << reasons(report);
    EXPECT_GT(ticks_beyond, 120U);
    EXPECT_LT(ticks_beyond, 180U);
}

}  // namespace
}  // namespace zoned::app
