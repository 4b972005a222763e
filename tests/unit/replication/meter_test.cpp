// The bandwidth meter: every byte of every body has one type, one reason and one field.
#include "tests/unit/replication/session.h"

#include <gtest/gtest.h>

namespace zoned::replication {
namespace {

/// A busy world: entities come, go, rest, change their looks; clients wander in and out of reach.
std::uint64_t run_metered(Session& s,
                          int ticks,
                          std::vector<mailbox::StatePacket>* sent = nullptr) {
    std::uint64_t bytes = 0;
    s.radius = 30.0F;
    s.near = 12.0F;
    for (int tick = 0; tick < ticks; ++tick) {
        if (tick % 37 == 36) {
            s.world.entities.remove(5 + s.world.rng.below(20));
            s.world.spawn(tick % 2 == 0 ? kBody : kWalker);
        }
        s.step();
        for (const mailbox::StatePacket& p : s.packets) {
            bytes += p.body.size();
            if (sent != nullptr) {
                sent->push_back(p);
            }
        }
    }
    return bytes;
}

TEST(BandwidthMeter, CountsEveryByteOfEveryBodyOnce) {
    for (const NetSettings& net : {NetSettings{}, NetSettings{0.2F, 0.05F, 2, 3}}) {
        ReplicationSettings settings = test_settings();
        settings.meter = true;
        Session s(31, settings, net, 25, 25, 5, 50.0F);
        const std::uint64_t bytes = run_metered(s, 600);
        const wire::TrafficTable* table = s.replicator.traffic();
        ASSERT_NE(table, nullptr);
        EXPECT_EQ(table->bits(), 8 * bytes);
        std::uint64_t by_reason = 0;
        for (std::size_t r = 0; r < wire::kTrafficReasons; ++r) {
            by_reason += table->bits(static_cast<wire::TrafficReason>(r));
        }
        std::uint64_t by_part = 0;
        for (std::size_t p = 0; p < wire::kTrafficParts; ++p) {
            by_part += table->bits_of_part(p);
        }
        EXPECT_EQ(by_reason, 8 * bytes);
        EXPECT_EQ(by_part, 8 * bytes);
    }
}

TEST(BandwidthMeter, TellsReasonsApart) {
    using wire::TrafficReason;
    const auto table_of = [](const NetSettings& net) {
        ReplicationSettings settings = test_settings();
        settings.meter = true;
        Session s(32, settings, net, 25, 25, 5, 50.0F);
        run_metered(s, 600);
        return *s.replicator.traffic();
    };
    const wire::TrafficTable good = table_of({});
    const wire::TrafficTable bad = table_of({0.2F, 0.0F, 2, 3});
    for (const TrafficReason reason : {TrafficReason::kUpdate,
                                       TrafficReason::kKeyframe,
                                       TrafficReason::kJoin,
                                       TrafficReason::kRemoval,
                                       TrafficReason::kHead}) {
        EXPECT_GT(good.bits(reason), 0U) << static_cast<int>(reason);
    }
    // Where nothing is lost nothing is sent again; a path is taken for a lossy one at first, so
    // that there may be copies.
    EXPECT_EQ(good.bits(TrafficReason::kResent), 0U);
    EXPECT_GT(bad.bits(TrafficReason::kRepeat), 4 * good.bits(TrafficReason::kRepeat));
    EXPECT_GT(bad.bits(TrafficReason::kRepeat), bad.bits() / 5);
    EXPECT_EQ(good.bits(TrafficReason::kUnread), 0U);
}

TEST(BandwidthMeter, CallsWhatCameOfNoBreachAHeartbeat) {
    const auto bits = [](std::uint32_t every, int ticks) {
        ReplicationSettings settings = test_settings();
        settings.meter = true;
        settings.heartbeat_ticks = every;
        for (LodBound& lod : settings.lods) {
            lod.position_m = 1000.0F;
            lod.orientation_rad = 100.0F;
        }
        Session s(33, settings, {}, 20, 0, 2, 20.0F);
        s.radius = 500.0F;
        s.near = 400.0F;
        for (int tick = 0; tick < ticks; ++tick) {
            s.step();
        }
        return s.replicator.traffic()->bits(wire::TrafficReason::kHeartbeat);
    };
    // Bounds so wide that only the velocity can leave them. All other publications are heartbeats,
    // and none comes before it is due.
    EXPECT_GT(bits(10, 230), 3 * bits(60, 230));
    EXPECT_GT(bits(60, 230), 0U);
    EXPECT_EQ(bits(240, 230), 0U);
}

TEST(BandwidthMeter, ChangesNothingOfWhatIsSent) {
    std::vector<mailbox::StatePacket> with;
    std::vector<mailbox::StatePacket> without;
    ReplicationSettings settings = test_settings();
    const NetSettings net{0.1F, 0.05F, 2, 3};
    Session plain(34, settings, net, 25, 25, 5, 50.0F);
    settings.meter = true;
    Session metered(34, settings, net, 25, 25, 5, 50.0F);
    run_metered(plain, 300, &without);
    run_metered(metered, 300, &with);
    EXPECT_EQ(plain.replicator.traffic(), nullptr);
    ASSERT_EQ(with.size(), without.size());
    for (std::size_t i = 0; i < with.size(); ++i) {
        EXPECT_EQ(with[i].body, without[i].body);
    }
}

}  // namespace
}  // namespace zoned::replication
