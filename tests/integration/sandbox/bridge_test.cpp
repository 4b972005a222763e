// The world `bridge`: people on two floors, some on a bridge and some below it at the same place.
#include "server/zone/zone_state.h"
#include "tests/harness/game_test.h"

#include <algorithm>
#include <cmath>

namespace zoned::harness {
namespace {

class BridgeWorld : public GameTest {
  protected:
    BridgeWorld() {
        server.config = ZONED_SOURCE_DIR "/config/bridge.txtpb";
        bots.bots = 4;
        bots.seconds = 100.0;
    }

    /// Where those with minds stand who have come to the place on the bridge, and below it.
    void look(app::World& of) {
        const zone::ZoneState& state = of.zones().front()->state();
        const world::Entities& e = state.entities;
        for (world::Row row = 0; row < e.size(); ++row) {
            const world::EntityType& type = (*state.settings.types)[e.type[row]];
            const Vec3& at = e.position[row];
            if (type.mind == 0 || std::hypot(at.x(), at.z()) > 3.0F) {
                continue;
            }
            const float feet = at.y() - type.radius - type.half_segment;
            (std::abs(feet - 3.0F) < 0.3F ? on_ : std::abs(feet) < 0.3F ? below_ : between_) += 1;
        }
    }

    int on_ = 0;
    int below_ = 0;
    int between_ = 0;
};

TEST_F(BridgeWorld, IsConsistentAndItsPeopleFindTheirFloors) {
    server.network.loss = 0.02;
    server.network.delay_s = 0.04;
    const measure::Report report = run([this](VirtualServer& now, double) { look(now.world()); });
    EXPECT_TRUE(report.consistent) << reasons(report);
    // Sixteen people, for some 30 s of 40 at each place.
    EXPECT_GT(on_, 1000);
    EXPECT_GT(below_, 1000);
    EXPECT_LT(between_, (on_ + below_) / 100);
    const ai::Ways& ways = world->world().zones().front()->state().ways;
    EXPECT_EQ(ways.sizes(), 2U) << "people and oxen";
    EXPECT_GT(ways.counts().broken, 0U) << "the gate shut before somebody";
}

}  // namespace
}  // namespace zoned::harness
