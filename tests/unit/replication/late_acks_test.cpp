// Late acknowledgements: what is late is not lost.
#include "tests/unit/replication/session.h"
#include "shared/wire/resend_timeout.h"

#include <vector>

namespace zoned::replication {
namespace {

/// A zone whose clients' acknowledgements wait before they are read, as where a machine is short of
/// CPU: no packet is lost.
class LateAcks {
  public:
    LateAcks() : session_(5, settings(), network(), 20, 20, 2, 25.0F) { session_.radius = 90.0F; }

    struct Sums {
        std::uint64_t sent = 0;
        std::uint64_t resent = 0;
    };

    /// So many ticks; acknowledgements wait for `late_ticks` more than the path takes.
    Sums run(int ticks, int late_ticks) {
        Sums sums;
        for (int tick = 0; tick < ticks; ++tick) {
            for (Remote& remote : session_.remotes) {
                remote.up.settings_.delay_ticks = 1 + late_ticks;
            }
            session_.step();
            sums.sent += session_.report.records_sent;
            sums.resent += session_.report.records_resent;
        }
        return sums;
    }

    static ReplicationSettings settings() {
        ReplicationSettings s = test_settings();
        s.budget_bytes_per_s = 200000;
        return s;
    }

    static NetSettings network() {
        NetSettings net;
        net.delay_ticks = 1;
        return net;
    }

    Session session_;
};

TEST(LateAcks, AreNoReasonToSendAgain) {
    LateAcks world;
    world.run(150, 0);  // in which the guess of a poor path is forgotten
    const LateAcks::Sums calm = world.run(300, 0);
    EXPECT_EQ(calm.resent, 0U);
    world.run(30, 12);  // in which the delay is learned
    const LateAcks::Sums late = world.run(300, 12);
    ASSERT_GT(late.sent, 1000U);
    EXPECT_EQ(late.resent, 0U) << "of " << late.sent;
}

/// The first ticks after the delay grew cost probes, which are few.
TEST(LateAcks, CostAFewProbesWhileTheDelayIsLearned) {
    LateAcks world;
    world.run(450, 0);
    const LateAcks::Sums onset = world.run(30, 12);
    ASSERT_GT(onset.sent, 100U);
    EXPECT_LT(onset.resent, onset.sent / 3);
}

TEST(LateAcks, LeaveNothingBehindWithinTwoSeconds) {
    LateAcks world;
    world.run(450, 0);
    world.run(90, 12);
    world.run(60, 0);
    EXPECT_EQ(world.run(120, 0).resent, 0U);
}

/// The path of a client that has just joined is taken for a poor one, but not for long: copies
/// ahead of losses come when many join at once, which is when they are least wanted.
TEST(LateAcks, OfANewClientCallForCopiesForAFewSecondsAlone) {
    LateAcks world;
    EXPECT_GT(world.run(30, 0).resent, 0U);
    world.run(90, 0);
    EXPECT_EQ(world.run(120, 0).resent, 0U);
}

/// After a stall an acknowledgement names the newest packet and 32 before it. The packets before
/// these were not reported at all: their updates are sent again, but the path has lost nothing.
TEST(LateAcks, ThatDoNotReachBackToAllPacketsAreNoLosses) {
    LateAcks world;
    const auto stall = [&](int ticks) {
        for (Remote& remote : world.session_.remotes) {
            remote.up.settings_.loss = 1.0F;
        }
        world.run(ticks, 14);
        for (Remote& remote : world.session_.remotes) {
            remote.up.settings_.loss = 0.0F;
        }
    };
    world.run(300, 14);
    stall(35);  // an outage, in which nothing counts, begins after 36 ticks
    world.run(60, 14);
    EXPECT_EQ(world.run(120, 14).resent, 0U);
}

/// Copies for a lossy path are given up while acknowledgements are late, whatever the loss.
TEST(LateAcks, GiveUpTheCopiesOfALossyPathFirst) {
    LateAcks world;
    for (Remote& remote : world.session_.remotes) {
        remote.down.settings_.loss = 0.08F;
    }
    const auto repeated = [&](int ticks, int late_ticks) {
        std::uint64_t sum = 0;
        for (int tick = 0; tick < ticks; ++tick) {
            world.run(1, late_ticks);
            sum += world.session_.report.records_repeated;
        }
        return sum;
    };
    repeated(300, 0);
    EXPECT_GT(repeated(150, 0), 100U);
    repeated(30, 10);
    repeated(30, 20);
    repeated(60, 30);
    EXPECT_EQ(repeated(150, 30), 0U);
    repeated(90, 0);
    EXPECT_GT(repeated(150, 0), 100U) << "the way back";
}

/// Where nothing comes from any of many clients, the server's own receiving is behind.
TEST(LateAcks, OfAllClientsAtOnceAreNotEvenProbedFor) {
    ReplicationSettings settings = test_settings();
    settings.budget_bytes_per_s = 200000;
    Session session(9, settings, {0.0F, 0.0F, 1, 0}, 20, 20, 12, 25.0F);
    session.radius = 90.0F;
    const auto run = [&](int ticks, float up_loss) {
        std::uint32_t given_up = 0;
        for (Remote& remote : session.remotes) {
            remote.up.settings_.loss = up_loss;
        }
        for (int tick = 0; tick < ticks; ++tick) {
            session.step();
            given_up += session.report.packets_given_up;
        }
        return given_up;
    };
    run(150, 0.0F);
    EXPECT_EQ(run(20, 1.0F), 0U);
    EXPECT_EQ(run(60, 0.0F), 0U);
}

TEST(Loss, IsMadeUpForWithinThePromise) {
    for (const int delay_ticks : {1, 3, 8}) {
        ReplicationSettings settings = test_settings();
        settings.budget_bytes_per_s = 200000;
        NetSettings net;
        net.delay_ticks = delay_ticks;
        Session session(6, settings, net, 10, 10, 1, 25.0F);
        session.radius = 90.0F;
        for (int tick = 0; tick < 150; ++tick) {
            session.step();
        }
        session.world.freeze();  // the last updates of all; nothing newer makes up for them
        session.remotes[0].down.settings_.loss = 1.0F;
        session.step();
        session.remotes[0].down.settings_.loss = 0.0F;
        ASSERT_GT(session.report.records_sent, 0U);
        const double rtt_s = (2.0 * delay_ticks + 1.0) * static_cast<double>(kTickS);
        const Tick granted = 1 + wire::resend_timeout_ticks(rtt_s, static_cast<double>(kTickS));
        std::uint32_t resent = 0;
        for (Tick waited = 1; waited <= granted; ++waited) {
            session.step();
            resent += session.report.records_resent;
        }
        EXPECT_GT(resent, 0U) << delay_ticks;
        for (int tick = 0; tick < 2 * delay_ticks; ++tick) {
            session.step();
        }
        session.expect_converged();
    }
}

TEST(Reach, EndsAllPacketsAndTheWayBackBringsWhatChanged) {
    Session session(7, test_settings(), {}, 20, 20, 2, 25.0F);
    session.radius = 90.0F;
    for (int tick = 0; tick < 60; ++tick) {
        session.step();
    }
    session.remotes[0].up.settings_.loss = 1.0F;
    session.step();
    session.replicator.set_reach(ClientId(1), false);
    for (int tick = 0; tick < 120; ++tick) {
        session.step();
        EXPECT_EQ(session.report.unreached, 1U);
        for (const mailbox::StatePacket& packet : session.packets) {
            EXPECT_EQ(packet.client, ClientId(2)) << "made and thrown away";
        }
    }
    EXPECT_FALSE(session.replicator.reaches(ClientId(1)));
    session.replicator.set_reach(ClientId(1), true);
    session.remotes[0].up.settings_.loss = 0.0F;
    for (int tick = 0; tick < 30; ++tick) {
        session.step();
    }
    session.world.freeze();
    for (int tick = 0; tick < 60; ++tick) {
        session.step();
    }
    session.expect_converged();
}

/// The message that a client is back may be lost in a full mailbox.
TEST(Reach, ComesBackWithAnyAcknowledgementOrInput) {
    Session session(8, test_settings(), {}, 5, 0, 1, 25.0F);
    for (int tick = 0; tick < 30; ++tick) {
        session.step();
    }
    session.replicator.set_reach(ClientId(1), false);
    session.replicator.on_heard(ClientId(1));
    EXPECT_TRUE(session.replicator.reaches(ClientId(1)));
}

}  // namespace
}  // namespace zoned::replication
