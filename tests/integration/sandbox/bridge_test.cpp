// The world `bridge`: people on two floors, some on a bridge and some below it at the same place.
#include "server/app/world/world.h"
#include "server/zone/zone_state.h"
#include "tests/harness/game_test.h"

#include <algorithm>
#include <cmath>
#include <string_view>

namespace zoned::harness {
namespace {

class BridgeWorld : public GameTest {
  protected:
    BridgeWorld() {
        server.config = ZONED_SOURCE_DIR "/config/bridge.txtpb";
        bots.bots = 4;
        bots.seconds = 100.0;
    }

    /// The agent that stands at the place on the bridge or below it, and whether that is its goal.
    void look(app::World& of) {
        const zone::ZoneState& state = of.zones().front()->state();
        const world::Entities& e = state.entities;
        for (world::Row row = 0; row < e.size(); ++row) {
            const ai::Agent* agent = state.agents.find(e.id[row]);
            const Vec3& at = e.position[row];
            if (agent == nullptr || std::hypot(at.x(), at.z()) > 1.5F) {
                continue;
            }
            const ai::CompiledBrain& brain = state.settings.ai.compiled[agent->brain];
            const std::string_view current_action = brain.states[agent->current_action].name;
            const world::EntityType& type = (*state.settings.types)[e.type[row]];
            const float feet = at.y() - type.radius - type.half_segment;
            if (current_action == "up") {
                (std::abs(feet - 3.0F) < 0.3F ? on_ : astray_) += 1;
            } else if (current_action == "down") {
                (std::abs(feet) < 0.3F ? below_ : astray_) += 1;
            }
        }
    }

    int on_ = 0;
    int below_ = 0;
    int astray_ = 0;
};

TEST_F(BridgeWorld, IsConsistentAndItsPeopleFindTheirFloors) {
    server.network.loss = 0.02;
    server.network.delay_s = 0.04;
    const measure::RunReport report =
        run([this](VirtualServer& now, double) { look(now.world()); });
    EXPECT_TRUE(report.consistent) << reasons(report);
    // Sixteen people, for some 30 s of 40 at each place.
    EXPECT_GT(on_, 1000);
    EXPECT_GT(below_, 1000);
    EXPECT_LT(astray_, (on_ + below_) / 100) << "on the wrong floor";
    const ai::PathService& paths = world->world().zones().front()->state().paths;
    EXPECT_EQ(paths.sizes(), 2U) << "people and oxen";
    EXPECT_GT(paths.counts().broken, 0U) << "the gate shut before somebody";
}

}  // namespace
}  // namespace zoned::harness
