// Kills and trades on bad networks: every client concerned ends with the same decision, once.
#include "server/app/world/world.h"
#include "server/rules/sandbox.h"
#include "tests/harness/game_test.h"
#include "tests/integration/sandbox/shooters_world.h"
#include "proto/sandbox.pb.h"

namespace zoned::harness {
namespace {

constexpr const char* kArena = R"(
world { name: "arena" seed: 7 min_x_m: -30 min_z_m: -30 max_x_m: 30 max_z_m: 30 }
type { name: "ball" sphere { radius_m: 0.2 } mass_kg: 1 aura_m { normal: 100 } }
entity { type: "ball" x_m: 0 y_m: 0.2 z_m: 1 asleep: true }
entity { type: "ball" x_m: 2 y_m: 0.2 z_m: 1 asleep: true }
spawn { x_m: 0 z_m: 0 } spawn { x_m: 2 z_m: 0 }
lod { position_bound_m: 0.05 orientation_bound_rad: 0.1 }
rules { name: "respawn_s" value: "1" }
)";

class Agreed : public GameTest {
  protected:
    Agreed() {
        server.config = kShootersWorld;
        server.config += kArena;
        server.config_is_text = true;
        server.network.delay_s = 0.05;
        server.network.jitter_s = 0.02;
        server.network.loss = 0.3;
        server.network.outage_every_s = 2.0;
        server.network.outage_length_s = 0.25;
        bots.freeze = false;
    }

    const rules::Sandbox& game() const {
        return dynamic_cast<const rules::Sandbox&>(*world->world().zones()[0]->state().rules);
    }

    const rules::CharacterRecord& record(const bot::Bot& bot) const {
        return *game().find(bot.avatar());
    }

    void expect_all_agree() const {
        for (const auto& bot : swarm->bots()) {
            ASSERT_NE(game().find(bot->avatar()), nullptr);
            const rules::CharacterRecord& truth = record(*bot);
            EXPECT_EQ(bot->ledger().deaths(), truth.deaths);
            EXPECT_EQ(bot->ledger().kills(), truth.kills);
            EXPECT_EQ(bot->ledger().trades(), truth.trades);
            std::vector<std::uint32_t> items;
            for (const rules::Item& item : truth.inventory) {
                items.push_back(item.id.value);
            }
            EXPECT_EQ(bot->ledger().items(), items);
            EXPECT_EQ(truth.ledger_repeats, 0u) << "the server knows that it agrees";
        }
    }

    static std::string offer(std::uint32_t with, std::uint32_t give, std::uint32_t want) {
        sandbox::Offer message;
        message.set_with(with);
        message.set_give(give);
        message.set_want(want);
        return message.SerializeAsString();
    }

    /// Both pick up the ball before them, and trade twice with the same offer: the second is
    /// refused.
    void trade(double now_s) {
        if (swarm->bots().size() < 2 || !swarm->bots()[1]->joined()) {
            return;
        }
        bot::Bot& a = *swarm->bots()[0];
        bot::Bot& b = *swarm->bots()[1];
        const auto due = [&](int step, double at_s) {
            return step_ == step && now_s > at_s;
        };
        if (due(0, 2.0)) {
            ++step_;
            for (bot::Bot* bot : {&a, &b}) {
                sandbox::PickUp pick;
                pick.set_entity(bot == &a ? balls_[0] : balls_[1]);
                bot->command(sandbox::COMMAND_PICK_UP, pick.SerializeAsString());
            }
        } else if (due(1, 3.0)) {
            ++step_;
            a.command(sandbox::COMMAND_OFFER, offer(b.avatar().value, balls_[0], balls_[1]));
        } else if (due(2, 4.0)) {
            ++step_;
            b.command(sandbox::COMMAND_ACCEPT, offer(a.avatar().value, balls_[0], balls_[1]));
            b.command(sandbox::COMMAND_ACCEPT, offer(a.avatar().value, balls_[0], balls_[1]));
            world->cut_streams();
        }
    }

    /// Compared before the goodbye, after all decisions have had their time.
    measure::RunReport play(bool trading) {
        bool compared = false;
        return run([&](VirtualServer& virtual_server, double now_s) {
            if (balls_.empty()) {
                const world::Entities& e = virtual_server.world().zones()[0]->state().entities;
                balls_ = {e.id[0].value, e.id[1].value};
            }
            if (trading) {
                trade(now_s);
            }
            if (now_s > bots.seconds - 6.0 && !quiet_) {
                quiet_ = true;
                for (const auto& bot : swarm->bots()) {
                    bot->set_quiet(true);
                }
            }
            if (now_s > bots.seconds - 0.1 && !compared) {
                compared = true;
                expect_all_agree();
                deaths_ = 0;
                kills_ = 0;
                for (const auto& bot : swarm->bots()) {
                    deaths_ += bot->ledger().deaths();
                    kills_ += bot->ledger().kills();
                }
                stats_ = game().stats();
            }
        });
    }

    std::vector<std::uint32_t> balls_;
    int step_ = 0;
    bool quiet_ = false;
    std::uint64_t deaths_ = 0;
    std::uint64_t kills_ = 0;
    rules::GameStats stats_;
};

TEST_F(Agreed, KillsAreHeldAlikeByBothSidesExactlyOnce) {
    bots.bots = 4;
    bots.seconds = 20.0;
    bots.mix = *bot::parse_mix("fight:1");
    const auto report = play(false);
    EXPECT_TRUE(report.consistent) << reasons(report);
    EXPECT_GT(stats_.kills, 3u);
    EXPECT_EQ(deaths_, stats_.kills);
    EXPECT_EQ(kills_, stats_.kills);
    EXPECT_GE(stats_.confirmed, 2 * stats_.kills - stats_.kills_unconfirmed);
    EXPECT_EQ(report.decisions_diverged, 0u);
    EXPECT_EQ(stats_.ledgers_diverged, 0u);
}

TEST_F(Agreed, ATradeHappensOnceOrNotAtAll) {
    bots.bots = 2;
    bots.seconds = 10.0;
    bots.mix = *bot::parse_mix("idle:1");
    const auto report = play(true);
    EXPECT_TRUE(report.consistent) << reasons(report);
    EXPECT_EQ(stats_.trades, 1u);
    EXPECT_EQ(stats_.confirmed, 2u);
    ASSERT_EQ(swarm->bots()[0]->ledger().items().size(), 1u);
    EXPECT_EQ(swarm->bots()[0]->ledger().items()[0], balls_[1]);
    EXPECT_EQ(swarm->bots()[1]->ledger().items()[0], balls_[0]);
    EXPECT_EQ(report.decisions_diverged, 0u);
}

/// The checker is checked: a client that misses a decision is found out, and corrected.
TEST_F(Agreed, DivergenceIsFoundAndResetAndTurnsTheVerdict) {
    bots.bots = 4;
    bots.seconds = 20.0;
    bots.mix = *bot::parse_mix("fight:1");
    server.sets = {"testing.drop_decision.probability=1"};
    const auto report = play(false);  // which still ends with all in agreement
    EXPECT_FALSE(report.consistent);
    EXPECT_TRUE(has_reason(report, "decisions")) << reasons(report);
    EXPECT_GT(stats_.ledgers_diverged, 0u);
    EXPECT_EQ(stats_.confirmed, 0u);
}

/// A dead player stands still on his own screen as well. He learns of his death within a round
/// trip, the ticks between two own states and the lead of his commands: some 15 ticks of 1/60 s at
/// 5 m/s.
TEST_F(GameTest, NobodyWalksOnWhileHeIsDead) {
    server.config = kShootersWorld;
    const std::string body = "character { }";
    server.config.replace(server.config.find(body), body.size(), "character { sprint_factor: 1 }");
    server.config += R"(
world { name: "meadow" seed: 7 min_x_m: -30 min_z_m: -30 max_x_m: 30 max_z_m: 30 }
spawn { x_m: 0 z_m: 0 } spawn { x_m: 2 z_m: 0 }
lod { position_bound_m: 0.05 orientation_bound_rad: 0.1 }
rules { name: "respawn_s" value: "3" }
)";
    server.config_is_text = true;
    bots.bots = 4;
    bots.seconds = 20.0;
    bots.mix = *bot::parse_mix("fight:1,wander:1");
    const auto report = run();
    EXPECT_TRUE(report.consistent) << reasons(report);
    std::uint64_t deaths = 0;
    for (const auto& bot : swarm->bots()) {
        deaths += bot->ledger().deaths();
    }
    EXPECT_GT(deaths, 3u);
    EXPECT_LT(report.own_correction_m.max(), 1.25);
}

}  // namespace
}  // namespace zoned::harness
