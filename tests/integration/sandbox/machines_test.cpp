// The world `machines`: cars that bots drive, ragdolls, a rope bridge and a crane, across a border.
#include "server/app/world/world.h"
#include "server/rules/sandbox.h"
#include "server/zone/zone_state.h"
#include "tests/harness/game_test.h"

#include <algorithm>
#include <set>

namespace zoned::harness {
namespace {

class Machines : public GameTest {
  protected:
    Machines() {
        server.config = ZONED_SOURCE_DIR "/config/machines.txtpb";
        bots.bots = 20;
        bots.seconds = 25.0;
        bots.mix = bot::parse_mix("drive:6,fight:2,wander:2").value();
    }

    void look(app::World& now) {
        for (const auto& zone : now.zones()) {
            const zone::ZoneState& state = zone->state();
            const world::Entities& e = state.entities;
            for (const zone::Rider& ride : state.assemblies.riders) {
                riders_.insert(ride.rider);
                const world::Row row = e.find(ride.carrier);
                if (ride.drives && row != world::kNoRow) {
                    fastest_ = std::max(fastest_, e.velocity[row].norm());
                }
            }
            for (world::Row row = 0; row < e.size(); ++row) {
                const std::string& type = (*state.settings.types)[e.type[row]].name;
                ragdolls_ += type == "ragdoll" && !e.has(row, world::kGhost) ? 1 : 0;
            }
        }
    }

    std::set<EntityId> riders_;
    float fastest_ = 0.0F;
    int ragdolls_ = 0;
};

TEST_F(Machines, AreSeenAsPromisedWhileBotsDriveThem) {
    const measure::RunReport report =
        run([this](VirtualServer& now, double) { look(now.world()); });
    EXPECT_TRUE(report.consistent) << reasons(report);
    EXPECT_EQ(report.bots_joined, 20U);
    EXPECT_GT(report.audit.samples, 1000U);
    EXPECT_GE(riders_.size(), 3U);
    EXPECT_GT(fastest_, 4.0F);
    EXPECT_GT(ragdolls_, 0) << "somebody was killed";
}

TEST_F(Machines, AreSeenAsPromisedOnABadNetwork) {
    server.network.loss = 0.05;
    server.network.delay_s = 0.04;
    const measure::RunReport report =
        run([this](VirtualServer& now, double) { look(now.world()); });
    EXPECT_TRUE(report.consistent) << reasons(report);
    EXPECT_GT(report.audit.samples_after_loss, 0U);
    EXPECT_GE(riders_.size(), 3U);
}

}  // namespace
}  // namespace zoned::harness
