// The worlds of config/methods whose names begin with ai_: each shows what its head says.
#include "server/app/world/world.h"
#include "server/zone/zone_state.h"
#include "tests/harness/game_test.h"

#include <cmath>
#include <map>
#include <string>
#include <vector>

namespace zoned::harness {
namespace {

/// Counts where and when NPCs pass x = 0.
class AiMethods : public GameTest {
  protected:
    AiMethods() {
        bots.bots = 3;
        server.network.delay_s = 0.03;
    }

    void play(const std::string& name) {
        server.config = ZONED_SOURCE_DIR "/config/methods/" + name + ".txtpb";
        before_.clear();
        const measure::RunReport report =
            run([this](VirtualServer& now, double) { look(now.world()); });
        EXPECT_TRUE(report.consistent) << reasons(report);
    }

    /// An NPC passes x = 0 at `z_m` in the n-th second.
    virtual void passes(double z_m, double second) = 0;

  private:
    void look(app::World& now) {
        const zone::ZoneState& state = now.zones().front()->state();
        const world::Entities& e = state.entities;
        for (std::size_t n = 0; n < state.agents.size(); ++n) {
            const EntityId id = state.agents.at(state.agents.nth(n)).entity;
            const world::Row row = e.find(id);
            const double x = static_cast<double>(e.position[row].x());
            const auto [at, fresh] = before_.try_emplace(id.value, x);
            if (!fresh && at->second * x < 0.0) {
                passes(static_cast<double>(e.position[row].z()),
                       static_cast<double>(state.now * state.settings.dt));
            }
            at->second = x;
        }
    }

    std::map<std::uint32_t, double> before_;
};

class RoadsWorld : public AiMethods {
  protected:
    void passes(double z_m, double second) override {
        const double phase = std::fmod(second, 60.0);
        const bool on_bridge = std::abs(z_m - 25.0) < 3.0;
        const bool in_ford = std::abs(z_m) < 3.0;
        ++(on_bridge ? bridge : in_ford ? ford : elsewhere);
        // The bridge is up from the 35th second to the 60th.
        wrong += on_bridge && phase > 35.5 ? 1 : 0;
        // A carrier halfway through the ford goes on: 16 m at 4 m/s.
        wrong += in_ford && phase > 4.0 && phase < 35.0 ? 1 : 0;
    }

    int bridge = 0;
    int ford = 0;
    int elsewhere = 0;
    int wrong = 0;
};

/// The sums of weights decide: 94 by the bridge against 120 by the ford, which is 18 m shorter.
TEST_F(RoadsWorld, CarriersTakeTheEasierWayAndTheHarderOneWhileItIsShut) {
    bots.seconds = 75.0;
    play("ai_roads");
    std::printf("bridge %d, ford %d\n", bridge, ford);
    EXPECT_GE(bridge, 12);
    EXPECT_GE(ford, 6);
    EXPECT_EQ(elsewhere, 0) << "the southern ford is blocked";
    EXPECT_EQ(wrong, 0);
}

class GatesWorld : public AiMethods {
  protected:
    struct Passed {
        int straight = 0;
        int aside = 0;
    };

    Passed passed(const std::vector<std::string>& sets) {
        bots.seconds = 25.0;
        server.sets = sets;
        passed_ = Passed();
        play("ai_gates");
        std::printf("straight %d, aside %d\n", passed_.straight, passed_.aside);
        return passed_;
    }

    void passes(double z_m, double /*second*/) override {
        ++(std::abs(z_m) < 3.0 ? passed_.straight : passed_.aside);
    }

  private:
    Passed passed_;
};

/// From where the crowd is, no shortest path leads through the gate aside.
TEST_F(GatesWorld, ACrowdTakesBothGatesAndGetsThroughSooner) {
    const Passed around = passed({});
    const Passed shortest = passed({"ai.pathfinding.crowding="});
    EXPECT_GE(around.aside, 8);
    EXPECT_EQ(shortest.aside, 0);
    EXPECT_GT(around.straight + around.aside, shortest.straight + 10);
}

}  // namespace
}  // namespace zoned::harness
