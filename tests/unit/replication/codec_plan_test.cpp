// CodecPlan: clients with dense views and short downlink get coded records, within the work budget.
#include "server/replication/codec_plan.h"

#include "tests/unit/replication/session.h"

#include <gtest/gtest.h>

namespace zoned::replication {
namespace {

constexpr mailbox::CodecPrice kPrice{1000, 2000};

/// Sent so many records in a packet each tick, of a downlink of `allowed` bytes a tick.
CodecWish wish(std::uint32_t records, double allowed) {
    CodecWish w;
    for (int tick = 0; tick < 2000; ++tick) {
        w.demand.add(records, records > 0 ? 1 : 0, allowed);
    }
    return w;
}

TEST(CodecPlan, CodesForTheDenseAndTheShortOfDownlink) {
    std::vector<CodecWish> wishes{wish(0, 1e4), wish(2, 1e4), wish(10, 1e4), wish(2, 150.0)};
    CodecPlan plan;
    const CodecChoice choice = plan.choose(wishes, kPrice, 1e9);
    EXPECT_FALSE(wishes[0].coded) << "told nothing";
    EXPECT_FALSE(wishes[1].coded) << "two records a packet, and room for a hundred";
    EXPECT_TRUE(wishes[2].coded);
    EXPECT_TRUE(wishes[3].coded) << "two records fill two thirds of what may be sent";
    EXPECT_EQ(choice.coded, 2u);
    EXPECT_EQ(choice.little_to_gain, 2u);
    EXPECT_EQ(choice.beyond_budget, 0u);
    // Twelve records and two packets.
    EXPECT_NEAR(choice.cost_ns, 12.0 * 1000 + 2.0 * 2000, 1.0);
}

TEST(CodecPlan, SpendsNoMoreThanItMayOnTheFullestDownlinksFirst) {
    std::vector<CodecWish> wishes;
    for (int i = 0; i < 10; ++i) {
        wishes.push_back(wish(8, 500.0 - 20.0 * i));
    }
    CodecPlan plan;
    // Each costs 8 us and 2 us: three fit into 35 us.
    const CodecChoice choice = plan.choose(wishes, kPrice, 35e3);
    EXPECT_EQ(choice.coded, 3u);
    EXPECT_EQ(choice.beyond_budget, 7u);
    EXPECT_LE(choice.cost_ns, 35e3);
    for (std::size_t i = 0; i < wishes.size(); ++i) {
        EXPECT_EQ(wishes[i].coded, i >= 7) << i;
    }
    EXPECT_EQ(plan.choose(wishes, kPrice, 0.0).coded, 0u);
}

TEST(CodecPlan, LeavesWhoIsCodedAloneWhileLittleChanges) {
    CodecPlan plan;
    std::vector<CodecWish> wishes{wish(3, 1e4), wish(3, 1e4)};
    wishes[1].coded = true;
    plan.choose(wishes, kPrice, 1e9);
    EXPECT_FALSE(wishes[0].coded) << "three records are too few to begin";
    EXPECT_TRUE(wishes[1].coded) << "but not to go on";
    // Of two alike that can't both be paid for, the one that is coded stays.
    std::vector<CodecWish> alike{wish(8, 500.0), wish(8, 500.0)};
    alike[1].coded = true;
    plan.choose(alike, kPrice, 15e3);
    EXPECT_FALSE(alike[0].coded);
    EXPECT_TRUE(alike[1].coded);
}

/// A crowd in which all see all.
Session crowd(const ReplicationSettings& settings, const NetSettings& net) {
    Session s(31, settings, net, 30, 10, 4, 20.0F);
    s.radius = 90.0F;
    return s;
}

ReplicationSettings automatic() {
    ReplicationSettings settings = test_settings();
    settings.codec = Codec::kAuto;
    settings.budget_bytes_per_s = 6000;
    return settings;
}

TEST(Replicator, ChangesCodecsAtAnyTimeAndConverges) {
    for (const NetSettings& net :
         {NetSettings{}, NetSettings{0.1F, 0.1F, 2, 3}, NetSettings{0.1F, 0.3F, 1, 20}}) {
        Session s = crowd(automatic(), net);
        std::uint32_t most = 0, changes = 0, before = 0;
        for (int tick = 0; tick < 1200; ++tick) {
            if (tick % 97 == 0) {
                // By turns, coding costs next to nothing and far more than the budget.
                s.replicator.set_codec_price(tick % 2 == 0 ? mailbox::CodecPrice{1, 1}
                                                           : mailbox::CodecPrice{1000000, 1});
            }
            if (tick % 37 == 36) {
                s.world.entities.remove(5 + s.world.rng.below(20));
                s.world.spawn(tick % 2 == 0 ? kBody : kWalker);
            }
            s.step();
            most = std::max(most, s.report.codec.coded);
            changes += s.report.codec.coded != before ? 1 : 0;
            before = s.report.codec.coded;
        }
        EXPECT_GE(most, 3u);
        EXPECT_GE(changes, 8u);
        s.world.freeze();
        for (int tick = 0; tick < 200; ++tick) {
            s.step();
        }
        s.expect_converged();
    }
}

TEST(Replicator, SpendsNoMoreOnCodingThanItMay) {
    ReplicationSettings settings = automatic();
    settings.codec_budget_us = 40;
    Session s = crowd(settings, {});
    constexpr mailbox::CodecPrice kDear{2000, 5000};
    s.replicator.set_codec_price(kDear);
    double spent_ns = 0.0;
    int coded_before = 0;
    constexpr int kTicks = 900;
    for (int tick = 0; tick < kTicks; ++tick) {
        s.step();
        spent_ns += static_cast<double>(s.report.coded_packets) * kDear.packet_ns +
                    static_cast<double>(s.report.coded_records) * kDear.record_ns;
    }
    for (const Remote& remote : s.remotes) {
        coded_before += remote.model.coded_packets;
    }
    EXPECT_GT(coded_before, 100);
    // Four ticks' worth may have gathered, and one client's packet may be dearer than its mean.
    EXPECT_LE(spent_ns, 1e3 * settings.codec_budget_us * (kTicks + 4) + 60.0 * kDear.record_ns);
    EXPECT_GT(spent_ns, 0.2 * 1e3 * settings.codec_budget_us * kTicks);
}

}  // namespace
}  // namespace zoned::replication
