// A truthful fake server under a bot and the collector: the verdict is consistent, and each fault
// gives the right reason.
#include "client-sim/bot/bot.h"
#include "client-sim/measure/collector.h"
#include "tests/unit/client/fake_server.h"

#include <gtest/gtest.h>

#include <memory>
#include <string>
#include <vector>

namespace zoned::measure {
namespace {

struct VerdictTest : testing::Test {
    void make(std::size_t count = 1, const link::ConditionerSettings& path = {}) {
        collector = std::make_unique<Collector>(count, 28, 0.0);
        for (std::size_t i = 0; i < count; ++i) {
            link::ConditionerSettings own = path;
            own.seed = path.seed + i;
            servers.push_back(std::make_unique<test::FakeServer>(own));
            for (std::uint32_t id = 1; id <= 10; ++id) {
                test::FakeEntity& e = servers.back()->entities[id];
                e.truth.position = Vec3(static_cast<float>(id) * 3.0F, 1.0F, 2.0F);
                e.truth.velocity = Vec3(1.0F, 0.0F, 0.1F * static_cast<float>(id));
            }
            bot::BotSettings settings;
            settings.index = i;
            settings.script = bot::Script::kIdle;
            settings.audit_every_s = 0.5;
            settings.view = kind;
            settings.convergence = convergence;
            bots.push_back(
                std::make_unique<bot::Bot>(*servers.back(), worlds, *collector, settings));
            bots.back()->start(0.0);
        }
    }

    void run_for(double seconds) {
        const double end = now + seconds;
        while (now < end) {
            now += 0.004;
            for (auto& server : servers) {
                server->advance(now);
            }
            for (auto& bot : bots) {
                bot->advance(now);
            }
            collector->advance(bots, now);
        }
    }

    RunReport finish() {
        collector->end_run(bots, now);
        RunReport r = collector->report(bots, bots.size());
        judge(r);
        return r;
    }

    static link::ConditionerSettings bad_path() {
        link::ConditionerSettings path;
        path.delay_s = 0.060;
        path.jitter_s = 0.020;
        path.loss = 0.05;
        path.duplicate = 0.02;
        path.reorder = 0.05;
        return path;
    }

    static bool has_reason(const RunReport& r, const std::string& start) {
        for (const std::string& reason : r.reasons) {
            if (reason.rfind(start, 0) == 0) {
                return true;
            }
        }
        return false;
    }

    static std::string all(const RunReport& r) {
        std::string text;
        for (const std::string& reason : r.reasons) {
            text += reason + "\n";
        }
        return text;
    }

    test::FakeServer& server() { return *servers.front(); }

    view::ViewKind kind = view::ViewKind::kExtrapolate;
    motion::ConvergenceMethod convergence = motion::ConvergenceMethod::kProjectiveVelocity;
    view::WorldCache worlds;
    std::unique_ptr<Collector> collector;
    std::vector<std::unique_ptr<test::FakeServer>> servers;
    Bots bots;
    double now = 0.0;
};

TEST_F(VerdictTest, IsConsistentWithATruthfulServer) {
    make(2);
    run_for(6.0);
    const RunReport r = finish();
    EXPECT_TRUE(r.consistent) << all(r);
    EXPECT_GT(r.audit.samples, 100U);
    EXPECT_LT(r.audit.predicted_m.max(), 0.07);
    EXPECT_EQ(r.bots_joined, 2U);
    EXPECT_GT(r.down_bytes_per_s.percentile(0.5), 100.0);
}

TEST_F(VerdictTest, IsConsistentOverABadPath) {
    make(3, bad_path());
    run_for(3.0);
    // Sudden changes within the declared limit of 5 m/s.
    for (int i = 0; i < 20; ++i) {
        for (auto& s : servers) {
            for (auto& [id, e] : s->entities) {
                e.truth.velocity.x() = -e.truth.velocity.x() * 1.5F;
                if (std::abs(e.truth.velocity.x()) > 2.0F) {
                    e.truth.velocity.x() = 1.0F;
                }
            }
        }
        run_for(0.37);
    }
    const RunReport r = finish();
    EXPECT_TRUE(r.consistent) << all(r);
    EXPECT_GT(r.audit.samples_after_loss, 0U);
    EXPECT_GT(r.packets_lost, 0U);
}

/// The checks that hold whether the world is displayed now or as it was.
struct EitherView : VerdictTest, testing::WithParamInterface<view::ViewKind> {
    EitherView() { kind = GetParam(); }
};

TEST_P(EitherView, ToleratesAnErrorWithinTheBound) {
    make();
    run_for(3.0);
    server().entities[4].lie = Vec3(0.0F, 0.04F, 0.0F);
    run_for(3.0);
    const RunReport r = finish();
    EXPECT_TRUE(r.consistent) << all(r);
}

TEST_P(EitherView, FindsAHiddenEntity) {
    make();
    run_for(3.0);
    server().entities[4].hidden_from_client = true;
    run_for(3.0);
    const RunReport r = finish();
    EXPECT_TRUE(has_reason(r, "missing:")) << all(r);
    EXPECT_EQ(r.audit.position_violations + r.audit.extra, 0U);
}

/// Gone since the last record, and back, by a change of stance or because somebody looks round: the
/// first record after that proves nothing, the one after it does.
TEST_P(EitherView, MayLackAnEntityThatWentOutOfReachSinceTheLastRecord) {
    for (const bool stance : {false, true}) {
        for (const int records : {1, 2}) {
            collector = nullptr;
            bots.clear();
            servers.clear();
            now = 0.0;
            make();
            server().audit_on_request = false;
            run_for(2.0);
            server().send_audit();
            server().entities[4].hidden_from_client = true;
            run_for(0.3);
            server().entities[4].radii_tick = stance ? server().tick : 0;
            run_for(0.7);
            for (int i = 0; i < records; ++i) {
                server().send_audit();
                run_for(1.0);
            }
            run_for(2.0);
            const RunReport r = finish();
            EXPECT_EQ(r.audit.missing, records - 1U) << stance << all(r);
            EXPECT_GT(r.audit.samples, 15U);
        }
    }
}

TEST_P(EitherView, GoesBackWithAServerThatStoodStillAndPromisesWhatItPromised) {
    make();
    run_for(3.0);
    server().stopped = true;
    run_for(3.0);
    server().stopped = false;
    run_for(1.0);
    EXPECT_EQ(bots.front()->set_backs(), 1U);
    EXPECT_NEAR(
        static_cast<double>(bots.front()->view()->tick()), static_cast<double>(server().tick), 2.0);
    run_for(4.0);
    const RunReport r = finish();
    EXPECT_GT(r.audit.samples, 100U);  // of ten entities twice a second, half of them afterwards
    EXPECT_LT(r.audit.predicted_m.max(), 0.07);
    EXPECT_TRUE(r.consistent) << all(r);
    ASSERT_EQ(r.warnings.size(), 1U);
    EXPECT_EQ(r.warnings[0],
              "stall: the server dropped ticks and set its clock back, as 1 view noticed");
}

TEST_P(EitherView, FindsALeak) {
    make();
    run_for(3.0);
    server().entities[4].leaked = true;
    run_for(3.0);
    const RunReport r = finish();
    EXPECT_TRUE(has_reason(r, "leak:")) << all(r);
    EXPECT_EQ(r.audit.position_violations + r.audit.missing, 0U);
}

TEST_P(EitherView, ConvergesExactlyInAFrozenWorld) {
    make();
    run_for(3.0);
    server().frozen = true;
    run_for(1.5);
    EXPECT_EQ(collector->convergence(bots).converged, 1U);
    RunReport r = collector->report(bots, 1);
    r.freeze_asked = true;
    judge(r);
    EXPECT_TRUE(r.consistent) << all(r);
    // One quantisation step is a difference.
    server().entities[3].lie = Vec3(0.01F, 0.0F, 0.0F);
    run_for(1.5);
    r = collector->report(bots, 1);
    r.freeze_asked = true;
    judge(r);
    EXPECT_TRUE(has_reason(r, "frozen:")) << all(r);
}

INSTANTIATE_TEST_SUITE_P(Views,
                         EitherView,
                         testing::Values(view::ViewKind::kExtrapolate,
                                         view::ViewKind::kInterpolate),
                         [](const auto& test) {
                             return test.param == view::ViewKind::kExtrapolate ? "extrapolating"
                                                                               : "interpolating";
                         });

struct InterpolatingVerdictTest : VerdictTest {
    InterpolatingVerdictTest() { kind = view::ViewKind::kInterpolate; }
};

TEST_F(InterpolatingVerdictTest, KeepsTheBareBoundWithNothingForTheAgeOfUpdates) {
    link::ConditionerSettings path;
    path.delay_s = 0.080;
    make(2, path);
    run_for(3.0);
    // Sudden changes: an extrapolating view is off by 3 m/s times the age of its updates.
    for (int i = 0; i < 30; ++i) {
        for (auto& s : servers) {
            for (auto& [id, e] : s->entities) {
                e.truth.velocity.x() = -e.truth.velocity.x();
                e.truth.velocity.y() = i % 2 == 0 ? 1.0F : -1.0F;
            }
        }
        run_for(0.21);
    }
    run_for(1.0);
    const RunReport r = finish();
    EXPECT_TRUE(r.consistent) << all(r);
    EXPECT_GT(r.audit.samples, 100U);
    // Except for the first second, in which clock and playout settle.
    EXPECT_EQ(r.audit.update_age_s.percentile(0.8), 0.0);
    // The bound of 0.05 m and the quantum of sqrt(3) / 2 cm; the fake server publishes when the
    // position has left the bound, as the real one does.
    EXPECT_LT(r.audit.predicted_m.max(), 0.05 + 0.0087 + 1e-4);
    EXPECT_GE(bots[0]->view()->delay(), 3 + view::Playout::lead_ticks(1.0 / 30.0));
    EXPECT_LE(bots[0]->view()->delay(), 5 + view::Playout::lead_ticks(1.0 / 30.0));
}

TEST_F(InterpolatingVerdictTest, IsConsistentOverABadPath) {
    make(3, bad_path());
    run_for(3.0);
    for (int i = 0; i < 20; ++i) {
        for (auto& s : servers) {
            for (auto& [id, e] : s->entities) {
                e.truth.velocity.x() = -e.truth.velocity.x();
            }
        }
        run_for(0.37);
    }
    const RunReport r = finish();
    EXPECT_TRUE(r.consistent) << all(r);
    EXPECT_GT(r.audit.samples, 100U);
    EXPECT_GT(r.audit.samples_after_loss, 0U);
}

TEST_F(InterpolatingVerdictTest, FindsAPositionBeyondItsBound) {
    link::ConditionerSettings path;
    path.delay_s = 0.060;
    make(1, path);
    run_for(3.0);
    // Less than the allowance of an extrapolating view of the same path (0.05 m + 20 m/s2 D^2 / 2).
    server().entities[4].lie = Vec3(0.0F, 0.07F, 0.0F);
    run_for(3.0);
    const RunReport r = finish();
    EXPECT_TRUE(has_reason(r, "bound:")) << all(r);
    ASSERT_FALSE(r.audit.worst.empty());
    EXPECT_EQ(r.audit.worst.front().entity, EntityId(4));
    EXPECT_EQ(r.audit.missing + r.audit.extra, 0U);
}

TEST_F(VerdictTest, IsConsistentWithHermiteConvergenceOverABadPath) {
    convergence = motion::ConvergenceMethod::kHermite;
    link::ConditionerSettings path;
    path.delay_s = 0.060;
    path.jitter_s = 0.020;
    path.loss = 0.05;
    make(2, path);
    run_for(8.0);
    const RunReport r = finish();
    EXPECT_TRUE(r.consistent) << all(r);
}

TEST_F(VerdictTest, FindsAPositionBeyondItsBound) {
    make();
    run_for(3.0);
    server().entities[4].lie = Vec3(0.0F, 0.3F, 0.0F);
    run_for(3.0);
    const RunReport r = finish();
    EXPECT_TRUE(has_reason(r, "bound:")) << all(r);
    ASSERT_FALSE(r.audit.worst.empty());
    EXPECT_EQ(r.audit.worst.front().entity, EntityId(4));
    EXPECT_EQ(r.audit.missing + r.audit.extra, 0U);
}

TEST_F(VerdictTest, GrantsAppearingEntitiesARoundTrip) {
    link::ConditionerSettings path;
    path.delay_s = 0.1;
    make(1, path);
    run_for(3.0);
    for (std::uint32_t id = 20; id < 40; ++id) {
        test::FakeEntity& e = server().entities[id];
        e.truth.position = Vec3(5.0F, 1.0F, 5.0F);
        e.discontinuity_tick = server().tick;
        server().send_audit();
        run_for(0.25);
    }
    const RunReport r = finish();
    EXPECT_TRUE(r.consistent) << all(r);
}

TEST_F(VerdictTest, FindsLostAndDoubledEvents) {
    make();
    run_for(1.0);
    server().send_raw_event(1, 1 << 16);
    server().send_raw_event(3, 3 << 16);
    run_for(4.0);
    EXPECT_TRUE(has_reason(finish(), "events: 1 lost"));
    server().send_raw_event(4, 3 << 16);
    run_for(0.1);
    EXPECT_TRUE(has_reason(finish(), "events: 1 delivered twice"));
}

TEST_F(VerdictTest, FindsAnEventThatNotEverybodyHeard) {
    make(3);
    run_for(3.0);
    servers[0]->send_event(5 << 16, false, "world");
    servers[1]->send_event(5 << 16, false, "world");
    run_for(6.0);
    const RunReport r = finish();
    EXPECT_EQ(r.events_unheard, 1U);
    EXPECT_TRUE(has_reason(r, "events: 1 to everybody")) << all(r);
    EXPECT_EQ(r.event_spread_ms.count(), 1U);
}

TEST_F(VerdictTest, FindsAStall) {
    make();
    run_for(3.0);
    server().stalled = true;
    run_for(1.2);
    server().stalled = false;
    run_for(1.0);
    EXPECT_TRUE(has_reason(finish(), "stall: the server was silent"));
    server().stalled = true;
    run_for(3.0);
    const RunReport r = finish();
    EXPECT_TRUE(has_reason(r, "stall: 1 client heard nothing")) << all(r);
}

TEST_F(VerdictTest, SaysThatNothingWasComparedWithoutTheRight) {
    make();
    server().rights = 1;
    server().audit_on_request = true;
    run_for(4.0);
    EXPECT_TRUE(has_reason(finish(), "nothing was compared"));
}

TEST_F(VerdictTest, PredictsTheOwnAvatarWithoutCorrectionsOnACleanPath) {
    make();
    run_for(6.0);
    const RunReport r = finish();
    EXPECT_GT(r.own_correction_m.count(), 100U);
    EXPECT_EQ(r.own_correction_m.percentile(0.9), 0.0);
}

TEST_F(VerdictTest, AdaptsTheLeadUntilInputsArriveInTime) {
    link::ConditionerSettings path;
    path.delay_s = 0.12;
    path.jitter_s = 0.03;
    make(1, path);
    run_for(10.0);
    const std::uint64_t before = bots[0]->view()->stats().input_missing;
    run_for(10.0);
    // The first ten seconds were for learning; after them hardly a command comes too late.
    EXPECT_LE(bots[0]->view()->stats().input_missing - before, 3U);
    EXPECT_LE(bots[0]->lead_ticks(), 12);
}

TEST_F(VerdictTest, SurvivesHostileAudits) {
    make();
    run_for(2.0);
    core::Rng rng(4);
    for (int i = 0; i < 500; ++i) {
        proto::ServerMessage message;
        proto::AuditRecord& record = *message.mutable_audit();
        record.set_tick(static_cast<std::int64_t>(rng.next()) - (1 << 30));
        record.set_frozen(rng.below(2) == 0);
        proto::AuditEntity& e = *record.add_entities();
        e.set_entity(rng.below(20));
        e.set_type(rng.below(4));
        for (std::uint32_t k = rng.below(5); k > 0; --k) {
            e.add_position(1e300);
        }
        for (std::uint32_t k = rng.below(6); k > 0; --k) {
            e.add_orientation(std::numeric_limits<float>::quiet_NaN());
        }
        server().send(message);
        if (i % 10 == 0) {
            run_for(0.02);
        }
    }
    run_for(1.0);
    EXPECT_GT(finish().audit.malformed, 0U);
}

TEST_F(VerdictTest, IsInconclusiveWhereTheBotsWereServedTooLateAndSomethingIsWrong) {
    make();
    run_for(3.0);
    RunReport r = finish();
    EXPECT_STREQ(verdict_of(r), "consistent") << all(r);
    const auto judge_turns = [&](double late_s, int late_turns) {
        r.loop = {};
        double at_s = 0.0;
        for (int i = 0; i < 1000; ++i) {
            at_s += i < late_turns ? late_s : 0.010;
            r.loop.turn(at_s);
        }
        judge(r);
        return std::string(verdict_of(r));
    };
    EXPECT_EQ(judge_turns(0.050, 50), "consistent") << "a promise that was kept was kept";
    r.events_lost = 1;
    EXPECT_EQ(judge_turns(0.030, 1000), "inconsistent") << "each tick is served";
    EXPECT_EQ(judge_turns(0.050, 5), "inconsistent") << "a few are not";
    EXPECT_EQ(judge_turns(0.050, 50), "inconclusive");
    EXPECT_NE(r.inconclusive.find("the bots were the bottleneck"), std::string::npos);
    EXPECT_NE(to_json(r).find("\"inconclusive\""), std::string::npos);
}

}  // namespace
}  // namespace zoned::measure
