// The world `circuit`: runners and carriages on splines across a border, on-screen and off-screen.
#include "server/ai/steering/spline_following.h"
#include "server/app/world/world.h"
#include "server/zone/zone_state.h"
#include "tests/harness/game_test.h"

#include <algorithm>
#include <map>
#include <set>

namespace zoned::harness {
namespace {

class CircuitWorld : public GameTest {
  protected:
    CircuitWorld() {
        server.config = ZONED_SOURCE_DIR "/config/circuit.txtpb";
        bots.bots = 2;
        bots.seconds = 60.0;
    }

    /// How far followers are from their lanes, and in how many zones each was.
    void look(app::World& now) {
        for (const auto& zone : now.zones()) {
            const zone::ZoneState& state = zone->state();
            const ai::splines::SplineNetwork& net = *state.points_of_interest.tracks();
            for (std::size_t n = 0; n < state.agents.size(); ++n) {
                look(state, net, state.agents.at(state.agents.nth(n)));
            }
        }
    }

    void look(const zone::ZoneState& state,
              const ai::splines::SplineNetwork& net,
              const ai::Agent& agent) {
        const world::Row row = state.entities.find(agent.entity);
        if (row == world::kNoRow || agent.corner != ai::kOnTrack || agent.entered) {
            return;
        }
        slowest_ = std::min(slowest_, agent.band);
        fastest_ = std::max(fastest_, agent.band);
        zones_[agent.entity.value].insert(state.settings.id.value);
        lanes_[agent.entity.value].insert(agent.track.lane);
        const Vec3& at = state.entities.position[row];
        const Vec2d here = Vec2(at.x(), at.z()).cast<double>() + state.points_of_interest.origin();
        ++samples_;
        (agent.tier == ai::Tier::kSuspended ? suspended_ : awake_) += 1;
        if (agent.tier == ai::Tier::kActive && agent.track.from == ai::splines::kNoLane) {
            beside_ += net.lane(agent.track.lane).nearest(here).distance_m > 1.0 ? 1 : 0;
        }
    }

    std::map<std::uint32_t, std::set<std::uint32_t>> zones_;
    std::map<std::uint32_t, std::set<std::uint32_t>> lanes_;
    int samples_ = 0;
    int suspended_ = 0;
    int awake_ = 0;
    int beside_ = 0;
    float slowest_ = 1.0F;
    float fastest_ = 1.0F;
};

TEST_F(CircuitWorld, IsConsistentAndItsFollowersKeepToTheirTracks) {
    server.network.loss = 0.02;
    server.network.delay_s = 0.04;
    const measure::RunReport report =
        run([this](VirtualServer& now, double) { look(now.world()); });
    EXPECT_TRUE(report.consistent) << reasons(report);
    EXPECT_EQ(lanes_.size(), 20U) << "all came to their tracks";
    const auto in_two = [](const auto& seen) {
        return seen.second.size() > 1;
    };
    // The course crosses the border, and takes 45 s.
    EXPECT_GE(std::count_if(zones_.begin(), zones_.end(), in_two), 14);
    EXPECT_GE(std::count_if(lanes_.begin(), lanes_.end(), in_two), 10) << "they changed lanes";
    EXPECT_GT(awake_, samples_ / 10);
    EXPECT_GT(suspended_, samples_ / 100) << "at the ends of the road nobody looks";
    // Bots that stroll over the course have runners wait, catch up and keep away, within the caps.
    EXPECT_LT(slowest_, 0.9F);
    EXPECT_GE(slowest_, 0.8F);
    EXPECT_GT(fastest_, 1.1F);
    EXPECT_LE(fastest_, 1.2F);
    // An agent that avoids others leaves its lane by as much as that takes.
    EXPECT_LT(beside_, awake_ / 5);
}

}  // namespace
}  // namespace zoned::harness
