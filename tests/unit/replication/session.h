// Session: one replicator, a world, and clients behind a simulated network, driven tick by tick.
#pragma once

#include "tests/unit/replication/test_world.h"

#include <gtest/gtest.h>

#include <deque>

namespace zoned::replication {

inline constexpr ZoneId kZone(1);
inline constexpr std::size_t kOverhead =
    28 + 6 + 16 + 12;  // IP, UDP, datagram header, tag, transport

/// One zone, viewers, and remotes behind the same kind of network.
class Session {
  public:
    Session(std::uint64_t seed,
            const ReplicationSettings& s,
            const NetSettings& net,
            int walkers,
            int bodies,
            std::uint32_t clients,
            float extent)
        : settings(s),
          types(test_types()),
          world(seed, extent),
          replicator(settings) {
        for (int i = 0; i < walkers; ++i) {
            world.spawn(kWalker);
        }
        for (int i = 0; i < bodies; ++i) {
            world.spawn(kBody);
        }
        for (std::uint32_t c = 1; c <= clients; ++c) {
            world.entities.set_client(c - 1, ClientId(c));
            viewers.push_back({ClientId(c), world.entities.id[c - 1]});
            remotes.emplace_back(ClientId(c), types, settings, net, seed * 1000 + c * 2);
            ClientTransfer transfer;
            transfer.client = ClientId(c);
            replicator.add_client(transfer);
        }
    }

    void step() {
        for (Remote& remote : remotes) {
            remote.up.deliver(world.now + 1,
                              [&](const mailbox::Acks& a) { replicator.on_acks(a); });
        }
        world.step();
        visibility = world.visibility(viewers, radius, near);
        packets.clear();
        report = replicator.step(world.now, kZone, world.entities, types, visibility, own, packets);
        for (const mailbox::StatePacket& p : packets) {
            remotes[p.client.value - 1].down.send(world.now, p);
        }
        for (Remote& remote : remotes) {
            remote.down.deliver(world.now, [&](const mailbox::StatePacket& p) {
                remote.model.receive(p.sequence, p.body);
            });
            mailbox::Acks acks{remote.client,
                               remote.model.acks.newest(),
                               remote.model.acks.bits(),
                               static_cast<std::uint32_t>(
                                   (2 * remote.down.settings_.delay_ticks + 1) * kTickS * 1e6F)};
            remote.up.send(world.now, acks);
        }
    }

    /// Every client holds exactly the entities that it sees, exactly as quantised, and could decode
    /// everything.
    void expect_converged() {
        for (std::size_t i = 0; i < remotes.size(); ++i) {
            const ModelClient& model = remotes[i].model;
            EXPECT_EQ(model.undecodable, 0);
            EXPECT_EQ(model.malformed, 0);
            EXPECT_EQ(model.known.size(), visibility[i].visible.size());
            for (const world::Visible& v : visibility[i].visible) {
                const auto it = model.known.find(v.entity);
                ASSERT_NE(it, model.known.end());
                const world::Row row = world.entities.find(v.entity);
                const wire::QuantizedState truth =
                    wire::quantize(world.entities.kinematic(row),
                                   motion::PredictorOrder::kStatic,
                                   types[world.entities.type[row]].upright(),
                                   true,
                                   world.entities.appearance[row],
                                   wire::at_lod(settings.quantization, it->second.lod));
                EXPECT_TRUE(it->second.state == truth) << "entity " << v.entity.value;
                EXPECT_EQ(it->second.type, world.entities.type[row]);
            }
        }
    }

    ReplicationSettings settings;
    world::TypeTable types;
    TestWorld world;
    Replicator replicator;
    std::vector<world::Viewer> viewers;
    std::deque<Remote> remotes;
    std::vector<OwnInput> own;
    world::Visibility visibility;
    std::vector<mailbox::StatePacket> packets;
    ReplicationReport report;
    float radius = 60.0F;
    float near = 20.0F;
};

}  // namespace zoned::replication
