#include "client-sim/audit/bound.h"
#include "client-sim/link/arrival_log.h"
#include "client-sim/measure/corrections.h"
#include "client-sim/measure/run_report.h"
#include "shared/core/histogram.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <numbers>
#include <vector>

namespace zoned::measure {
namespace {

using namespace audit;  // the allowances

constexpr double kTick = 1.0 / 30.0;

TEST(AllowedPositionError, IsBoundAndQuantumAndAcceleratedDriftOnly) {
    BoundInputs in{0.05, 0.01, 0.1};
    EXPECT_DOUBLE_EQ(allowed_position_error(in, 20.0, 5.0), 0.05 + 0.01 + 0.5 * 20.0 * 0.01);
}

TEST(AllowedPositionError, CountsASuddenChangeExactlyWithinTheAgeOfUpdates) {
    BoundInputs in{0.05, 0.01, 0.1};
    const double without = allowed_position_error(in, 20.0, 5.0);
    in.since_breach_s = 0.1;
    EXPECT_DOUBLE_EQ(allowed_position_error(in, 20.0, 5.0), without + 0.5);
    in.since_breach_s = 0.1 + kTick;
    EXPECT_DOUBLE_EQ(allowed_position_error(in, 20.0, 5.0), without);
    in.since_breach_s = 0.0;
    EXPECT_DOUBLE_EQ(allowed_position_error(in, 20.0, 5.0), without + 0.5);
}

TEST(AllowedOrientationError, LetsCharactersTurnFreelyWithinTheAgeOfUpdates) {
    BoundInputs in{0.1, 0.01, 0.1};
    EXPECT_DOUBLE_EQ(allowed_orientation_error(in, true, 40.0), 0.11);
    in.since_breach_s = 0.05;
    // Half a turn, and no more than float's rounding of it.
    EXPECT_GE(allowed_orientation_error(in, true, 40.0),
              static_cast<double>(std::numbers::pi_v<float>));
    EXPECT_NEAR(allowed_orientation_error(in, true, 40.0), std::numbers::pi, 1e-4);
    EXPECT_DOUBLE_EQ(allowed_orientation_error({0.1, 0.01, 0.02, 0.0}, false, 40.0),
                     0.11 + 40.0 * 0.02);
}

TEST(PastAge, IsNothingOnceAllUpdatesOfTheDisplayedTickHaveCome) {
    const link::UpdateAge age{0.040, 0.040 + kTick, false, {}, true, 0.040 + kTick};
    EXPECT_EQ(past_age_s(age, age, 0.040), 0.0);
    EXPECT_EQ(past_age_s(age, age, 0.2), 0.0);
    // A tick that was displayed too early lacks younger updates.
    EXPECT_DOUBLE_EQ(past_age_s(age, age, 0.030), 0.010 + kTick);
    EXPECT_DOUBLE_EQ(past_age_s(age, age, 0.0), age.age_s);
}

TEST(PastAge, IsTheWholeAgeAfterALoss) {
    const link::UpdateAge good{0.040, 0.040 + kTick, false, {}, true, 0.040 + kTick};
    const link::UpdateAge bad{0.040, 0.180, true, {}, true, 0.040 + kTick};
    EXPECT_DOUBLE_EQ(past_age_s(good, bad, 0.2), 0.180);
    EXPECT_DOUBLE_EQ(past_age_s(bad, good, 0.2), 0.180);
    EXPECT_EQ(past_plain_s(bad, good, 0.2), 0.0) << "of what was not lost";
}

/// Packets of consecutive ticks, each `delay` old when it comes.
link::ArrivalLog steady(std::uint64_t count, double delay, std::vector<std::uint64_t> missing) {
    link::ArrivalLog log;
    log.set_tick_s(kTick);
    for (std::uint64_t s = 1; s <= count; ++s) {
        if (std::find(missing.begin(), missing.end(), s) == missing.end()) {
            log.on_packet(s, static_cast<Tick>(s), static_cast<double>(s) * kTick + delay);
        }
    }
    return log;
}

TEST(ArrivalLog, AddsOneTickToTheLargestDelayAround) {
    link::ArrivalLog log = steady(200, 0.040, {});
    const link::UpdateAge age = log.at(150, 0.08);
    EXPECT_TRUE(age.measured);
    EXPECT_FALSE(age.loss);
    EXPECT_NEAR(age.delay_s, 0.040, 1e-12);
    EXPECT_NEAR(age.age_s, 0.040 + kTick, 1e-12);
}

TEST(ArrivalLog, AddsAResendOnlyNearALostPacket) {
    link::ArrivalLog log = steady(200, 0.040, {150});
    EXPECT_EQ(log.missing(), 1U);
    const double rtt = 0.08;
    EXPECT_FALSE(log.at(149, rtt).loss);
    EXPECT_TRUE(log.at(151, rtt).loss);
    EXPECT_NEAR(log.at(152, rtt).age_s, 0.040 + kTick + rtt + kTick, 1e-12);
    // The server gives packet 150 up when it is more than 1 + 80 ms = 4 ticks old, and sends its
    // updates with tick 155. They arrive after 40 ms = 1.2 ticks; a tick later all is known.
    EXPECT_TRUE(log.at(157, rtt).loss);
    EXPECT_FALSE(log.at(158, rtt).loss);
}

/// On a path without delay the server waits longer than a round trip and a tick all the same.
TEST(ArrivalLog, GrantsTheResendTheTimeThatTheServerWaits) {
    link::ArrivalLog log = steady(200, 0.002, {150});
    const double rtt = 0.004;
    // Given up at tick 153 (more than 1 + 1 ticks old), here 2 ms later.
    EXPECT_TRUE(log.at(153, rtt).loss);
    EXPECT_TRUE(log.at(154, rtt).loss);
    EXPECT_FALSE(log.at(155, rtt).loss);
}

TEST(ArrivalLog, TakesALatePacketForLateNotForLost) {
    link::ArrivalLog log = steady(200, 0.040, {150});
    log.on_packet(150, 150, 150 * kTick + 0.120);
    EXPECT_EQ(log.missing(), 0U);
    const link::UpdateAge age = log.at(152, 0.08);
    EXPECT_FALSE(age.loss);
    EXPECT_NEAR(age.age_s, 0.120 + kTick, 1e-12) << "its delay counts instead";
}

TEST(ArrivalLog, TakesUpdatesAsOldAsAnOutage) {
    std::vector<std::uint64_t> gone;
    for (std::uint64_t s = 100; s < 160; ++s) {
        gone.push_back(s);
    }
    link::ArrivalLog log = steady(200, 0.040, gone);
    EXPECT_NEAR(log.at(150, 0.08).age_s, 51 * kTick, 1e-9);
}

/// A narrow budget makes packets rare; the state of the last one holds until the next.
TEST(ArrivalLog, TakesWhatWasToldForTrueUntilSomethingElseIsTold) {
    link::ArrivalLog log;
    log.set_tick_s(kTick);
    const auto packet = [&](std::uint64_t sequence, Tick tick, std::uint8_t step) {
        log.on_packet(sequence, tick, static_cast<double>(tick) * kTick + 0.01, {step, false});
    };
    packet(1, 100, 0);
    packet(2, 110, 5);
    packet(3, 120, 1);
    EXPECT_EQ(log.at(108, 0.02).widened.step, 0);
    EXPECT_EQ(log.at(118, 0.02).widened.step, 5);
    EXPECT_EQ(log.at(120, 0.02).widened.step, 5);
    EXPECT_EQ(log.at(128, 0.02).widened.step, 1);
}

TEST(ArrivalLog, SaysWhenNothingWasMeasured) {
    EXPECT_FALSE(steady(10, 0.04, {}).at(1000, 0.08).measured);
}

TEST(Corrections, AreErrorsButForTheFirstOneAfterAJump) {
    Corrections corrections;
    core::Histogram errors;
    core::Histogram jumps;
    for (Tick tick = 100; tick < 200; tick += 10) {
        corrections.add(tick, tick == 150 ? 300.0 : 0.01);
    }
    // The avatar joined at tick 40, long before; at 145 it was moved elsewhere.
    corrections.decide(139, 40, errors, jumps);
    EXPECT_EQ(errors.count() + jumps.count(), 4U);
    corrections.decide(169, 145, errors, jumps);
    corrections.decide(195, 145, errors, jumps);
    EXPECT_EQ(jumps.max(), 300.0);
    EXPECT_LT(errors.max(), 0.02);
    EXPECT_EQ(jumps.count(), 2U) << "one for the join, one for the jump";
    corrections.add(200, 70.0);
    corrections.finish(errors);
    EXPECT_LT(errors.max(), 0.02) << "nobody can say what that was";
}

TEST(Corrections, AreErrorsAllWhereNoAuditComes) {
    Corrections corrections;
    core::Histogram errors;
    corrections.add(5, 0.1);
    corrections.add(6, 3.0);
    corrections.finish(errors);
    EXPECT_EQ(errors.count(), 2U);
}

TEST(Staleness, BeginsBeyondWhatJitterAndReorderingExplain) {
    // 60 +- 20 ms in one direction, reordering by up to two ticks: the largest delay and a tick.
    const double least_rtt = 0.080;
    EXPECT_FALSE(is_stale(0.080 + 2 * kTick + kTick, least_rtt, kTick, false, 0.0));
    EXPECT_FALSE(is_stale(0.080 + 2 * kTick + kTick + 0.160 + kTick, least_rtt, kTick, true, 0.0));
    // A client on the same machine that was not scheduled for a quarter of a second.
    EXPECT_TRUE(is_stale(0.250, 0.001, kTick, false, 0.0));
    // Jitter that we make ourselves is not starvation; it excuses only the delay that it adds.
    EXPECT_FALSE(is_stale(0.250, 0.001, kTick, false, 0.100));
    EXPECT_TRUE(is_stale(0.600, 0.001, kTick, false, 0.100));
    EXPECT_FALSE(is_stale(0.001 + 2 * kTick, 0.001, kTick, false, 0.0));
}

TEST(Staleness, WarnsAndThenTurnsTheVerdict) {
    const auto judged = [](std::uint64_t stale) {
        RunReport r;
        r.bots_asked = r.bots_joined = 1;
        r.audit.samples = 1000;
        r.audit.samples_stale = stale;
        judge(r);
        return r;
    };
    EXPECT_TRUE(judged(50).consistent);
    EXPECT_TRUE(judged(50).warnings.empty());
    EXPECT_TRUE(judged(51).consistent);
    ASSERT_EQ(judged(51).warnings.size(), 1U);
    EXPECT_EQ(judged(51).warnings[0].rfind("stale: 5.1 %", 0), 0U);
    EXPECT_TRUE(judged(500).consistent);
    EXPECT_FALSE(judged(501).consistent);
    EXPECT_EQ(judged(501).reasons[0].rfind("stale: ", 0), 0U);
    EXPECT_NE(to_table(judged(60)).find("WARNING: stale"), std::string::npos);
    EXPECT_NE(to_json(judged(60)).find("\"warnings\": [\n    \"stale: 6 %"), std::string::npos);
}

TEST(RunReport, HoldsEveryFieldOfTheContract) {
    RunReport r;
    judge(r);
    const std::string json = to_json(r);
    for (const char* name : {"bots_asked",
                             "bots_joined",
                             "seconds",
                             "down_bytes_per_s_p50",
                             "down_bytes_per_s_p99",
                             "up_bytes_per_s_p50",
                             "up_bytes_per_s_p99",
                             "updates_per_s",
                             "position_error_m_p50",
                             "position_error_m_p99",
                             "position_error_m_max",
                             "predicted_error_m_p50",
                             "predicted_error_m_p99",
                             "predicted_error_m_max",
                             "bound_violations",
                             "samples",
                             "missing_entities",
                             "extra_entities",
                             "events_sent",
                             "events_delivered",
                             "events_duplicated",
                             "events_out_of_order",
                             "event_spread_ms_p99",
                             "input_to_remote_display_ms_p50",
                             "input_to_remote_display_ms_p99",
                             "rtt_ms_p50",
                             "rtt_ms_p99",
                             "clock_error_ms_p99",
                             "verdict",
                             "reasons"}) {
        EXPECT_NE(json.find("\"" + std::string(name) + "\":"), std::string::npos) << name;
    }
    EXPECT_FALSE(r.consistent) << "a run without bots shows nothing";
}

}  // namespace
}  // namespace zoned::measure
