#include "tests/harness/game_test.h"

namespace zoned::harness {
namespace {

constexpr double kRoundTripS = 0.1;

class Join : public GameTest {
  protected:
    Join() {
        server.network.delay_s = 0.5 * kRoundTripS;
        bots.bots = 1;
        bots.audit = false;
        bots.freeze = false;
    }

    /// Virtual time from login (Welcome) until the bot has its own state and `wanted` entities
    /// within `radius_m`; below 0: never.
    double playable_after_s(std::size_t wanted, double radius_m) {
        double welcome_s = -1.0;
        double playable_s = -1.0;
        run([&](VirtualServer&, double now_s) {
            if (!swarm || swarm->bots().empty() || playable_s >= 0.0) {
                return;
            }
            const bot::Bot& bot = *swarm->bots().front();
            if (welcome_s < 0.0 && bot.client().state() == link::SessionState::kOnline) {
                welcome_s = now_s;
            }
            if (welcome_s < 0.0 || bot.view() == nullptr || !bot.view()->own().known()) {
                return;
            }
            std::size_t near = 0;
            const Vec3d here = bot.view()->own().position();
            const view::EntityStore& store = bot.view()->store();
            for (const auto& [id, entity] : store.entities()) {
                if (entity.present()) {
                    const Vec3d there =
                        store.predicted(entity.versions.back(), bot.view()->tick()).position;
                    near += (there - here).norm() < radius_m ? 1 : 0;
                }
            }
            if (near >= wanted) {
                playable_s = now_s;
            }
        });
        return playable_s < 0.0 ? -1.0 : playable_s - welcome_s;
    }
};

TEST_F(Join, IsPlayableWithinTwoRoundTripsOfLogin) {
    bots.seconds = 3.0;
    // 10 crates and 2 wanderers on 100 x 100 m: all are heard.
    const double after_s = playable_after_s(12, 200.0);
    ASSERT_GE(after_s, 0.0);
    EXPECT_LT(after_s, 2.0 * kRoundTripS);
}

TEST_F(Join, PredictsItsOwnAvatarToACentimetre) {
    bots.seconds = 30.0;
    bots.bots = 2;
    bots.audit = true;
    bots.mix = {{bot::Behaviour::kWander, 1.0}};
    const auto report = run();
    EXPECT_TRUE(report.consistent) << reasons(report);
    ASSERT_GT(report.own_correction_m.count(), 100U);
    EXPECT_LT(report.own_correction_m.percentile(0.99), 0.01);
}

}  // namespace
}  // namespace zoned::harness
