// The greatest age of one entity's updates, by lost packets; and the excuse of a budget.
#include "client-sim/audit/update_age.h"

#include "client-sim/bot/bot.h"
#include "client-sim/measure/collector.h"
#include "tests/unit/client/fake_server.h"
#include "shared/core/rng.h"

#include <gtest/gtest.h>

#include <set>

namespace zoned::measure {
namespace {

using audit::age_of;
using audit::SentUpdates;

constexpr double kTick_s = 1.0 / 30.0;
constexpr double kDelay_s = 0.040;
constexpr double kRtt_s = 0.080;
constexpr double kResend_s = kRtt_s + kTick_s;
/// A packet without an answer is given up when it is older than 1 + 3 ticks: one tick later.
constexpr double kGivenUp_s = 5.0 * kTick_s;

/// One packet a tick, with the sequence of its tick.
link::ArrivalLog log_without(const std::set<Tick>& lost) {
    link::ArrivalLog log;
    log.set_tick_s(kTick_s);
    for (Tick t = 1; t <= 200; ++t) {
        if (lost.count(t) == 0) {
            log.on_packet(
                static_cast<std::uint64_t>(t), t, static_cast<double>(t) * kTick_s + kDelay_s);
        }
    }
    return log;
}

SentUpdates carried_by(std::initializer_list<Tick> ticks) {
    SentUpdates sent_updates;
    for (const Tick t : ticks) {
        sent_updates.packets.push_back({t, static_cast<std::uint64_t>(t)});
    }
    return sent_updates;
}

link::UpdateAge age_at(Tick tick,
                       const link::ArrivalLog& log,
                       const SentUpdates& sent_updates,
                       bool complete = false) {
    const double shown_s = static_cast<double>(tick) * kTick_s;
    return age_of(
        log.at(tick, kRtt_s), sent_updates, complete, log, tick, shown_s, kRtt_s, kTick_s);
}

TEST(AgeOf, IsThatOfAllUpdatesWhereThisEntityLostNone) {
    const link::ArrivalLog log = log_without({148, 149, 150, 151, 152, 153});
    const link::UpdateAge around = log.at(153, kRtt_s);
    EXPECT_TRUE(around.loss);
    EXPECT_DOUBLE_EQ(age_at(153, log, carried_by({})).age_s, around.age_s);
    EXPECT_DOUBLE_EQ(age_at(153, log, carried_by({140, 147})).age_s, around.age_s);
}

TEST(ArrivalLog, CountsWhatWasReadAfterAStallOfTheClient) {
    link::ArrivalLog log;
    log.set_tick_s(kTick_s);
    // Asleep for six seconds from tick 20 on: all that came meanwhile is read at tick 200.
    for (Tick t = 1; t <= 260; ++t) {
        const double due_s = static_cast<double>(t) * kTick_s + kDelay_s;
        const double wake_s = 200 * kTick_s;
        log.on_packet(static_cast<std::uint64_t>(t), t, t > 20 ? std::max(due_s, wake_s) : due_s);
    }
    EXPECT_NEAR(log.at(15, kRtt_s).plain_s, kDelay_s + kTick_s, 1e-9);
    for (const Tick tick : {40, 100, 130, 199}) {
        const link::UpdateAge age = log.at(tick, kRtt_s);
        EXPECT_TRUE(age.measured);
        EXPECT_FALSE(age.loss);
        EXPECT_GE(age.plain_s, static_cast<double>(tick - 21 + 1) * kTick_s - 1e-9) << tick;
    }
    // Two seconds after it woke nothing is left of it.
    EXPECT_NEAR(log.at(261, kRtt_s).plain_s, kDelay_s + kTick_s, 1e-9);
}

TEST(AgeOf, GrantsNoResendWhereTheServerNamesAllPacketsAndNoneOfThisEntityWasLost) {
    const link::ArrivalLog log = log_without({150});
    EXPECT_TRUE(log.at(152, kRtt_s).loss);
    for (const SentUpdates& sent_updates : {carried_by({}), carried_by({148, 149, 151})}) {
        const link::UpdateAge age = age_at(152, log, sent_updates, true);
        EXPECT_FALSE(age.loss);
        EXPECT_NEAR(age.age_s, kDelay_s + kTick_s, 1e-9);
    }
    const link::UpdateAge lost = age_at(152, log, carried_by({150}), true);
    EXPECT_TRUE(lost.loss);
    EXPECT_NEAR(lost.age_s, kDelay_s + kTick_s + kResend_s, 1e-9);
}

TEST(AgeOf, IsWhatHasGoneBySinceTheFirstOfSeveralLostInARow) {
    const link::ArrivalLog log = log_without({148, 149, 150, 151, 152, 153});
    const link::UpdateAge age = age_at(154, log, carried_by({147, 148, 150, 152}));
    EXPECT_TRUE(age.loss);
    // The state of tick 147 was within its bound until 148.
    EXPECT_NEAR(age.age_s, 7 * kTick_s, 1e-9);
    EXPECT_GT(age.age_s, log.at(154, kRtt_s).age_s);
}

/// The server acts at ticks: a resend leaves up to two ticks later than a round trip and a tick.
TEST(AgeOf, CoversTheTickAtWhichAPacketIsGivenUp) {
    const link::ArrivalLog log = log_without({150});
    // The packet that tick 155 sends again comes at tick 157, and is shown from then on.
    EXPECT_NEAR(age_at(156, log, carried_by({150})).age_s, 7 * kTick_s, 1e-9);
}

/// The server does not decide how long it may take to send again.
TEST(AgeOf, GrantsNoMoreThanAResendForEachLoss) {
    const link::ArrivalLog log = log_without({140});
    for (const Tick tick : {150, 160, 180}) {
        const link::UpdateAge age = age_at(tick, log, carried_by({140}));
        EXPECT_LE(age.age_s, kDelay_s + kTick_s + kGivenUp_s + 1e-9) << tick;
    }
    const link::ArrivalLog twice = log_without({140, 145});
    EXPECT_NEAR(age_at(180, twice, carried_by({140, 145})).age_s,
                kDelay_s + kTick_s + 2.0 * kGivenUp_s,
                1e-9);
}

TEST(AgeOf, TakesWhatCameLastForAllThatWasBefore) {
    const link::ArrivalLog log = log_without({140, 141, 142, 143});
    const link::UpdateAge around = log.at(150, kRtt_s);
    EXPECT_DOUBLE_EQ(age_at(150, log, carried_by({140, 141, 142, 143, 144})).age_s, around.age_s);
}

TEST(AgeOf, BelievesNoLossThatTheClientDoesNotMiss) {
    const link::ArrivalLog log = log_without({});
    const link::UpdateAge around = log.at(150, kRtt_s);
    SentUpdates never_sent;
    for (std::uint64_t sequence = 1000; sequence < 1010; ++sequence) {
        never_sent.packets.push_back({130, sequence});
    }
    EXPECT_DOUBLE_EQ(age_at(150, log, never_sent).age_s, around.age_s);
    EXPECT_DOUBLE_EQ(age_at(150, log, carried_by({130, 131, 132})).age_s, around.age_s);
}

TEST(AgeOf, LooksAtNothingThatWasSentAfterTheTruth) {
    const link::ArrivalLog log = log_without({151, 152, 153, 154, 155});
    const link::UpdateAge around = log.at(150, kRtt_s);
    EXPECT_DOUBLE_EQ(age_at(150, log, carried_by({151, 152, 153, 154, 155})).age_s, around.age_s);
}

TEST(AgeOf, IsANumberWhateverTheServerNames) {
    const link::ArrivalLog log = log_without({140, 150});
    core::Rng rng(5);
    for (int i = 0; i < 2000; ++i) {
        SentUpdates sent_updates;
        for (std::uint32_t n = rng.below(40); n > 0; --n) {
            const Tick far = Tick{1} << 40;
            const Tick tick = rng.below(8) == 0 ? (rng.below(2) == 0 ? far : -far)
                                                : static_cast<Tick>(rng.below(300));
            const std::uint64_t wild = ~std::uint64_t{rng.below(3)};
            sent_updates.packets.push_back({tick, rng.below(8) == 0 ? wild : rng.below(300)});
        }
        const link::UpdateAge age = age_at(160, log, sent_updates, rng.below(2) == 0);
        EXPECT_GT(age.age_s, 0.0);
        EXPECT_LT(age.age_s, kDelay_s + kTick_s + 41.0 * kGivenUp_s);
    }
}

/// A bot and a server that keeps an entity from it and has a reason, or says so.
class Excuse : public testing::Test {
  protected:
    RunReport run(bool told, bool postponed) {
        test::FakeServer server;
        for (std::uint32_t id = 1; id <= 5; ++id) {
            server.entities[id].truth.position = Vec3(static_cast<float>(id) * 3.0F, 1.0F, 2.0F);
        }
        view::WorldCache worlds;
        Collector collector(1, 28, 0.0);
        bot::BotSettings settings;
        settings.script = bot::Script::kIdle;
        settings.audit_every_s = 0.5;
        Bots bots;
        bots.push_back(std::make_unique<bot::Bot>(server, worlds, collector, settings));
        bots[0]->start(0.0);
        for (double now = 0.0; now < 6.0; now += 0.004) {
            server.widened.incomplete = told && now > 3.0;
            server.entities[4].hidden_from_client = now > 3.0;
            server.entities[4].postponed = postponed && now > 3.0;
            server.advance(now);
            bots[0]->advance(now);
            collector.advance(bots, now);
            if (now + 0.004 >= 6.0) {
                collector.end_run(bots, now);
            }
        }
        RunReport r = collector.report(bots, 1);
        judge(r);
        return r;
    }
};

TEST_F(Excuse, IsABudgetThatMadeJustThisEntityWaitAsTheClientWasNotified) {
    const RunReport r = run(true, true);
    EXPECT_EQ(r.audit.missing, 0U);
    EXPECT_GT(r.audit.missing_notified, 0U);
}

TEST_F(Excuse, IsNoneWhereAnotherEntityWaits) {
    EXPECT_GT(run(true, false).audit.missing, 0U);
}

TEST_F(Excuse, IsNoneWhereTheClientWasNotNotified) {
    EXPECT_GT(run(false, true).audit.missing, 0U);
}

}  // namespace
}  // namespace zoned::measure
