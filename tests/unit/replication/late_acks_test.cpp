// Late acknowledgements: what is late is not lost.
#include "tests/unit/replication/session.h"

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
    world.run(150, 0);  // the estimate of the loss has come down
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

}  // namespace
}  // namespace zoned::replication
