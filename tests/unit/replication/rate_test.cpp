#include "tests/unit/replication/session.h"

namespace zoned::replication {
namespace {

/// Bytes of a tick with all overhead.
double wire_bytes(const std::vector<mailbox::StatePacket>& packets) {
    double bytes = 0.0;
    for (const mailbox::StatePacket& p : packets) {
        bytes += static_cast<double>(p.body.size() + kOverhead);
    }
    return bytes;
}

TEST(PathRate, IsKeptToByThePackerTickByTick) {
    ReplicationSettings settings = test_settings();
    settings.budget_bytes_per_s = 100000;
    Session s(3, settings, {}, 120, 120, 1, 40.0F);
    const double rate = 5000.0;
    double sent = 0.0;
    double most = 0.0;
    for (int tick = 0; tick < 600; ++tick) {
        mailbox::Acks acks;
        acks.client = ClientId(1);
        acks.rate_bytes_per_s = static_cast<std::uint32_t>(rate);
        s.replicator.on_acks(acks);
        s.step();
        if (tick >= 100) {
            sent += wire_bytes(s.packets);
            most = std::max(most, wire_bytes(s.packets));
        }
    }
    const double second = sent * 30.0 / 500.0;
    EXPECT_LT(second, 1.01 * rate);
    // There is always something to send here: at most a record per tick remains.
    EXPECT_GT(second, 0.9 * rate);
    // A tick and a half's worth at once, but at least a packet of which headers are a fifth or
    // less: more would wait in the path's queue.
    EXPECT_LE(most, std::max(512.0, 1.5 * rate * static_cast<double>(kTickS)) + 1.0);
}

TEST(PathRate, NeverLiftsTheConfiguredBudget) {
    ReplicationSettings settings = test_settings();
    settings.budget_bytes_per_s = 8000;
    Session s(3, settings, {}, 120, 120, 1, 40.0F);
    double sent = 0.0;
    for (int tick = 0; tick < 600; ++tick) {
        mailbox::Acks acks;
        acks.client = ClientId(1);
        acks.rate_bytes_per_s = 1'000'000;
        s.replicator.on_acks(acks);
        s.step();
        sent += tick >= 100 ? wire_bytes(s.packets) : 0.0;
    }
    EXPECT_LT(sent * 30.0 / 500.0, 1.01 * 8000.0);
}

TEST(PathRate, FollowsTheClientToAnotherZone) {
    ReplicationSettings settings = test_settings();
    Session s(3, settings, {}, 20, 20, 1, 40.0F);
    mailbox::Acks acks;
    acks.client = ClientId(1);
    acks.rate_bytes_per_s = 4321;
    s.replicator.on_acks(acks);
    EXPECT_EQ(s.replicator.remove_client(ClientId(1)).rate_bytes_per_s, 4321U);
}

}  // namespace
}  // namespace zoned::replication
