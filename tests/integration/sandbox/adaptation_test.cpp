// The world `learned`: bots that are bitten to death make hounds gentler, and bots that shoot them
// make them keener. Neither goes beyond the cap, and the log says so.
#include "server/app/log/difficulty_log.h"
#include "server/app/world/world.h"
#include "tests/harness/game_test.h"
#include "tests/scenario/log_text.h"

namespace zoned::harness {
namespace {

class AdaptationGame : public GameTest {
  protected:
    AdaptationGame() {
        server.config = ZONED_SOURCE_DIR "/config/learned.txtpb";
        server.sets = {"ai.adaptation.least_between_s=1",
                       "ai.adaptation.step=1",
                       "rules[2]={name: \"health\" value: \"20\"}"};
        bots.bots = 8;
        bots.seconds = 20.0;
    }

    /// Runs the bots; returns the log.
    std::string play(const std::string& mix) {
        const auto shares = bot::parse_mix(mix);
        EXPECT_TRUE(shares.ok());
        bots.mix = *shares;
        const scenario::LogText log;
        Tick logged_tick = -1;
        const measure::RunReport report = run([&](VirtualServer& now, double) {
            const zone::Zone& zone = *now.world().zones().front();
            if (zone.report().tick != logged_tick) {
                logged_tick = zone.report().tick;
                app::log_difficulty(zone);
                app::log_bands(app::bands_of(now.world().zones()), logged_tick, 300, bands);
            }
        });
        EXPECT_TRUE(report.consistent) << reasons(report);
        level = world->world().zones().front()->state().ai_update.difficulty().level;
        return log.text();
    }

    app::LoggedBands bands;
    std::uint16_t level = 0;
};

TEST_F(AdaptationGame, BotsWhoAreBittenMakeItEasier) {
    server.sets.emplace_back("rules[1].value=\"20\"");
    const std::string log = play("wander");
    EXPECT_EQ(level, 0) << log;
    EXPECT_NE(log.find("zone 1: difficulty fair -> gentle at tick"), std::string::npos) << log;
    EXPECT_NE(log.find("brain pacer: rubber bands of"), std::string::npos) << log;
}

/// Hounds bite for half of one per cent of a life.
TEST_F(AdaptationGame, BotsWhoHuntThemDownMakeItHarder) {
    server.sets.emplace_back("rules[1].value=\"0.1\"");
    const std::string log = play("hunt");
    EXPECT_EQ(level, 2) << log;
    EXPECT_NE(log.find("zone 1: difficulty fair -> keen at tick"), std::string::npos) << log;
}

TEST_F(AdaptationGame, StaysWithinItsCap) {
    server.sets.emplace_back("rules[1].value=\"20\"");
    server.sets.emplace_back("ai.adaptation.least=fair");
    const std::string log = play("wander");
    EXPECT_EQ(level, 1);
    EXPECT_EQ(log.find("difficulty fair ->"), std::string::npos) << log;
}

}  // namespace
}  // namespace zoned::harness
