// The world `hamlet`: its people live close to the edge of the world, and nobody goes over it.
#include "server/app/world/world.h"
#include "server/zone/zone_state.h"
#include "tests/harness/game_test.h"

namespace zoned::harness {
namespace {

TEST_F(GameTest, NobodyLeavesHamlet) {
    server.config = ZONED_SOURCE_DIR "/config/hamlet.txtpb";
    bots.bots = 2;
    bots.seconds = 60.0;
    std::uint64_t left = 0;
    const measure::RunReport report = run([&](VirtualServer& now, double) {
        for (const auto& zone : now.world().zones()) {
            left += zone->report().out_of_world;
        }
    });
    EXPECT_TRUE(report.consistent) << reasons(report);
    EXPECT_EQ(left, 0U);
}

}  // namespace
}  // namespace zoned::harness
