// Measured figures: bytes per client and time per tick.
#include "tests/unit/replication/test_world.h"

#include <gtest/gtest.h>

#include <chrono>
#include <cstdio>

namespace zoned::replication {
namespace {

constexpr double kOverhead = 28 + 6 + 16 + 12;

struct Load {
    double bytes_per_s = 0.0;
    double packets_per_s = 0.0;
    double publications_per_s = 0.0;
    double record_bytes = 0.0;
    double tick_ms = 0.0;
};

/// `viewers` of the walkers have clients; acks arrive a tick later.
Load measure(int walkers,
             std::uint32_t viewers,
             float radius,
             float near,
             int order,
             float extent) {
    const world::TypeTable types = test_types();
    ReplicationSettings settings = test_settings();
    settings.forced_order = order;
    TestWorld world(3, extent);
    Replicator replicator(settings);
    std::vector<world::Viewer> list;
    for (int i = 0; i < walkers; ++i) {
        const EntityId entity = world.spawn(kWalker);
        if (static_cast<std::uint32_t>(i) < viewers) {
            list.push_back({ClientId(static_cast<std::uint32_t>(i) + 1), entity});
            world.entities.set_client(static_cast<world::Row>(i), list.back().client);
            ClientTransfer transfer;
            transfer.client = list.back().client;
            replicator.add_client(transfer);
        }
    }
    std::vector<std::uint64_t> newest(viewers + 1, 0);
    std::vector<mailbox::StatePacket> packets;
    Load load;
    constexpr int kWarmUp = 60;
    constexpr int kTicks = 600;
    double seconds = 0.0, bytes = 0.0, count = 0.0, publications = 0.0, records = 0.0, bodies = 0.0;
    for (int tick = 0; tick < kWarmUp + kTicks; ++tick) {
        for (std::uint32_t c = 1; c <= viewers; ++c) {
            replicator.on_acks({ClientId(c), newest[c], ~0U, 33000});
        }
        world.step();
        const world::Visibility sets = world.visibility(list, radius, near);
        packets.clear();
        const auto begin = std::chrono::steady_clock::now();
        const ReplicationReport report =
            replicator.step(world.now, ZoneId(1), world.entities, types, sets, {}, packets);
        const auto end = std::chrono::steady_clock::now();
        for (const mailbox::StatePacket& p : packets) {
            newest[p.client.value] = p.sequence;
        }
        if (tick >= kWarmUp) {
            seconds += std::chrono::duration<double>(end - begin).count();
            count += report.packets;
            bytes += static_cast<double>(report.bytes) + kOverhead * report.packets;
            publications += report.publications;
            records += report.records_sent;
            bodies += static_cast<double>(report.bytes);
        }
    }
    const double span = kTicks * kTickS;
    load.bytes_per_s = bytes / span / viewers;
    load.packets_per_s = count / span / viewers;
    load.publications_per_s = publications / span;
    load.record_bytes = bodies / records;
    load.tick_ms = seconds / kTicks * 1e3;
    return load;
}

void print(const char* scene, const Load& l) {
    std::printf(
        "%-44s %7.0f B/s per client, %4.1f packets/s, %6.0f publications/s, %4.1f body "
        "bytes per record, %.3f ms per tick\n",
        scene,
        l.bytes_per_s,
        l.packets_per_s,
        l.publications_per_s,
        l.record_bytes,
        l.tick_ms);
}

TEST(Bandwidth, OfAWalkingCrowdStaysUnderTwentyFourKilobitsPerSecond) {
    for (const int order : {-1, 0, 1, 2, 3, 4}) {
        char name[64];
        std::snprintf(name, sizeof name, "8 walkers around a walking viewer, order %d", order);
        const Load load = measure(9, 1, 100.0F, 30.0F, order, 20.0F);
        print(name, load);
        if (order == -1) {
            EXPECT_LT(load.bytes_per_s, 3000.0);
        }
    }
}

TEST(Bandwidth, AndTimeOfAZoneWithManyViewersAreMeasured) {
    print("125 viewers, 625 walkers, about 25 visible",
          measure(625, 125, 100.0F, 30.0F, -1, 450.0F));
    print("100 viewers that all see each other", measure(100, 100, 200.0F, 200.0F, -1, 30.0F));
}

}  // namespace
}  // namespace zoned::replication
