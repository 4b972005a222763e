// Resent records, and their times; and the server's report of its attempts to send an entity.
#include "tests/unit/replication/session.h"

#include <gtest/gtest.h>

#include <algorithm>

namespace zoned::replication {
namespace {

/// A viewer, a body that rests before it, and a packet in every tick. Acknowledgements are given by
/// hand.
class Unacknowledged : public testing::Test {
  protected:
    Unacknowledged() {
        settings.silence_ticks = 1;
        replicator = std::make_unique<Replicator>(settings);
        world.spawn(kWalker);
        body = world.spawn(kBody);
        world.entities.set_client(0, kClient);
        world.freeze();
        ClientTransfer transfer;
        transfer.client = kClient;
        transfer.rtt_us = kRtt_us;
        transfer.loss_estimate = 0.05;  // so that copies are sent ahead
        replicator->add_client(transfer);
    }

    void step(bool visible) {
        world.step();
        world::Visibility sets(1);
        sets[0].client = kClient;
        if (visible) {
            sets[0].visible.push_back({body, 0});
        }
        std::vector<mailbox::StatePacket> packets;
        replicator->step(world.now, kZone, world.entities, types, sets, {}, packets);
        for (const mailbox::StatePacket& packet : packets) {
            newest = packet.sequence;
        }
    }

    void acknowledge(std::uint64_t sequence, std::uint32_t bits) {
        replicator->on_acks({kClient, sequence, bits, kRtt_us});
    }

    mailbox::AuditUpdate updates() {
        std::vector<mailbox::AuditUpdate> all;
        since = replicator->unacknowledged(kClient, all);
        const auto at = std::find_if(all.begin(), all.end(), [&](const mailbox::AuditUpdate& n) {
            return n.entity == body;
        });
        return at != all.end() ? *at : mailbox::AuditUpdate{};
    }

    /// Steps until no further copies are sent and none is given up; all packets that carried it.
    std::vector<mailbox::AuditUpdate::Carried> copies(bool visible) {
        for (int tick = 0; tick < 6; ++tick) {
            step(visible);
        }
        return updates().carried;
    }

    static constexpr ClientId kClient{1};
    static constexpr std::uint32_t kRtt_us = 1'000'000;  ///< nothing is given up meanwhile
    ReplicationSettings settings = test_settings();
    world::TypeTable types = test_types();
    TestWorld world{3, 10.0F};
    std::unique_ptr<Replicator> replicator;
    EntityId body;
    std::uint64_t newest = 0;
    Tick since = 0;
};

/// Not only when all copies are lost: by then a round trip has gone by in vain.
TEST_F(Unacknowledged, ACopyThatIsKnownToBeLostIsMadeUpForAtOnce) {
    for (const bool visible : {true, false}) {
        const auto sent = copies(visible);
        ASSERT_GE(sent.size(), 2U) << "the network may be a poor one";
        // Three packets after the first copy one has come: that copy is lost, the state of the last
        // is unknown.
        const std::uint64_t came = std::max(sent.front().sequence + 3, sent.back().sequence + 1);
        acknowledge(came, 0);
        step(visible);
        EXPECT_GT(updates().carried.size(), sent.size()) << visible;
        // Nor does it come later: that would show that the network only changes the order.
        std::uint32_t all_others = 0xFFFFFFFFU;
        for (const auto& copy : sent) {
            if (copy.sequence + 3 <= came) {
                all_others &= ~(1U << (newest - 1 - copy.sequence));
            }
        }
        acknowledge(newest, all_others);
        EXPECT_TRUE(updates().carried.empty()) << "nothing is told that has been acknowledged";
    }
}

TEST_F(Unacknowledged, NamesThePacketsSinceTheNewestThatWasAcknowledged) {
    const auto sent = copies(true);
    ASSERT_GE(sent.size(), 3U);
    EXPECT_EQ(since, 1) << "nothing is forgotten yet";
    for (std::size_t i = 1; i < sent.size(); ++i) {
        EXPECT_EQ(sent[i].sequence, sent[i - 1].sequence + 1);
        EXPECT_EQ(sent[i].tick, sent[i - 1].tick + 1);
    }
    acknowledge(sent[1].sequence, 0);
    const auto left = updates().carried;
    ASSERT_EQ(left.size(), sent.size() - 2) << "what came brought all that was before";
    EXPECT_EQ(left.front().sequence, sent[2].sequence);
    EXPECT_FALSE(updates().leaving);
}

TEST_F(Unacknowledged, SaysThatWhatTheyCarryIsARemoval) {
    copies(true);
    acknowledge(newest, 0xFFFFFFFFU);
    const auto sent = copies(false);
    EXPECT_TRUE(updates().leaving);
    EXPECT_GE(sent.size(), 2U);
    acknowledge(newest, 0xFFFFFFFFU);
    EXPECT_FALSE(updates().leaving);
}

TEST_F(Unacknowledged, SaysFromWhenOnItRemembers) {
    for (int tick = 0; tick < 100; ++tick) {
        step(true);
    }
    updates();
    EXPECT_GT(since, 30);
    EXPECT_LT(since, 40) << "64 packets are remembered, one a tick";
}

TEST_F(Unacknowledged, UpdatesAreSentOnceByAServerThatNeverSendsAgain) {
    settings.resend = false;
    replicator = std::make_unique<Replicator>(settings);
    ClientTransfer transfer;
    transfer.client = kClient;
    replicator->add_client(transfer);
    EXPECT_EQ(copies(true).size(), 1U);
}

}  // namespace
}  // namespace zoned::replication
