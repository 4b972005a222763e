#include "server/replication/replicator.h"

#include "tests/unit/replication/session.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <set>

namespace zoned::replication {
namespace {

struct Weather {
    NetSettings net;
    const char* name;
};

using WeatherAndCodec = std::tuple<Weather, Codec>;

std::string name_of(const testing::TestParamInfo<WeatherAndCodec>& tested) {
    const bool coded = std::get<1>(tested.param) == Codec::kPerClient;
    return std::string(std::get<0>(tested.param).name) + (coded ? "Coded" : "");
}

class ReplicatorInWeather : public testing::TestWithParam<WeatherAndCodec> {};

TEST_P(ReplicatorInWeather, ConvergesExactlyOnceTheWorldRests) {
    for (std::uint64_t seed = 1; seed <= 4; ++seed) {
        ReplicationSettings settings = test_settings();
        settings.codec = std::get<1>(GetParam());
        Session s(seed, settings, std::get<0>(GetParam()).net, 25, 25, 5, 50.0F);
        s.radius = 35.0F;
        s.near = 15.0F;
        for (int tick = 0; tick < 450; ++tick) {
            if (tick % 37 == 36) {
                // Entities cease to be and come to be; rows move.
                s.world.entities.remove(5 + s.world.rng.below(20));
                s.world.spawn(tick % 2 == 0 ? kBody : kWalker);
            }
            if (tick % 50 == 20) {
                s.world.entities.appearance[s.world.rng.below(40)] =
                    static_cast<std::uint16_t>(tick);
            }
            if (tick % 100 == 70) {
                const world::Row row = 5 + s.world.rng.below(20);
                s.world.entities.position[row].x() *= -1.0F;
                s.world.entities.discontinuity_tick[row] = s.world.now + 1;
            }
            if (tick == 200) {
                s.remotes[1].model.forget();
                s.remotes[1].model.undecodable = 0;
                s.replicator.reset_view(ClientId(2));
            }
            s.step();
            if (tick >= 200 && tick < 230) {
                s.remotes[1].model.undecodable = 0;  // deltas that crossed with the reset
            }
        }
        s.world.freeze();
        for (int tick = 0; tick < 150; ++tick) {
            s.step();
        }
        s.expect_converged();
        for (const Remote& remote : s.remotes) {
            EXPECT_EQ(remote.model.coded_packets > 50, settings.codec == Codec::kPerClient);
        }
        // Nothing is pending any more: only signs of life go out.
        std::uint32_t records = 0, packets = 0;
        for (int tick = 0; tick < 60; ++tick) {
            s.step();
            records += s.report.records_sent;
            packets += s.report.packets;
        }
        EXPECT_EQ(records, 0U);
        EXPECT_LE(packets, 5U * (60 / s.settings.silence_ticks + 1));
        EXPECT_GE(packets, 5U * (60 / s.settings.silence_ticks));
    }
}

INSTANTIATE_TEST_SUITE_P(Weathers,
                         ReplicatorInWeather,
                         testing::Combine(testing::Values(Weather{{0.0F, 0.0F, 0, 0}, "Perfect"},
                                                          Weather{{0.05F, 0.02F, 2, 1}, "Rain"},
                                                          Weather{{0.3F, 0.1F, 3, 4}, "Storm"},
                                                          Weather{{0.1F, 0.3F, 1, 20}, "Shuffled"}),
                                          testing::Values(Codec::kShared, Codec::kPerClient)),
                         name_of);

void follow_a_client_between_zones(Codec codec) {
    for (const NetSettings& net :
         {NetSettings{}, NetSettings{0.2F, 0.1F, 2, 3}, NetSettings{0.05F, 0.0F, 1, 8}}) {
        // Two zones that see the same world from different sides; the client wanders between them.
        ReplicationSettings settings = test_settings();
        settings.codec = codec;
        Session s(11, settings, net, 20, 20, 1, 50.0F);
        Replicator other(s.settings);
        Replicator* here = &s.replicator;
        Replicator* there = &other;
        core::Rng rng(5);
        std::vector<mailbox::StatePacket> packets;
        std::uint64_t last_sequence = 0;
        Remote& remote = s.remotes[0];
        world::Visibility set;
        for (int tick = 0; tick < 900; ++tick) {
            if (tick == 700) {
                s.world.freeze();
            }
            if (tick < 700 && rng.below(15) == 0) {
                there->add_client(here->remove_client(ClientId(1)));
                std::swap(here, there);
            }
            remote.up.deliver(s.world.now + 1, [&](const mailbox::Acks& a) {
                here->on_acks(a);
                there->on_acks(a);
            });
            s.world.step();
            set = s.world.visibility(s.viewers, here == &other ? 30.0F : 40.0F, 15.0F);
            packets.clear();
            const ZoneId zone(here == &other ? 2 : 1);
            here->step(s.world.now, zone, s.world.entities, s.types, set, {}, packets);
            const ReplicationReport idle =
                there->step(s.world.now, ZoneId(9), s.world.entities, s.types, {}, {}, packets);
            EXPECT_TRUE(idle.skipped);
            for (const mailbox::StatePacket& p : packets) {
                EXPECT_EQ(p.sequence, last_sequence + 1);
                last_sequence = p.sequence;
                remote.down.send(s.world.now, p);
            }
            remote.down.deliver(s.world.now, [&](const mailbox::StatePacket& p) {
                remote.model.receive(p.sequence, p.body);
            });
            remote.up.send(s.world.now,
                           {ClientId(1), remote.model.acks.newest(), remote.model.acks.bits(), 0});
            if (net.delay_ticks == 0 && net.loss == 0.0F) {
                s.visibility = set;
                EXPECT_EQ(remote.model.known.size(), set[0].visible.size());
            }
        }
        s.visibility = set;
        s.expect_converged();
    }
}

TEST(Replicator, FollowsAClientBetweenZones) {
    follow_a_client_between_zones(Codec::kShared);
}

TEST(Replicator, FollowsAClientBetweenZonesWithCodedRecords) {
    follow_a_client_between_zones(Codec::kPerClient);
}

TEST(Replicator, RespectsTheByteBudgetAndStarvesNobody) {
    ReplicationSettings settings = test_settings();
    settings.budget_bytes_per_s = 4000;
    Session s(12, settings, {}, 0, 150, 0, 20.0F);
    s.world.entities.set_client(0, ClientId(1));
    s.viewers.push_back({ClientId(1), s.world.entities.id[0]});
    s.remotes.emplace_back(ClientId(1), s.types, settings, NetSettings{}, 4);
    ClientTransfer transfer;
    transfer.client = ClientId(1);
    s.replicator.add_client(transfer);
    std::vector<double> sent;
    std::uint32_t over_budget = 0;
    for (int tick = 0; tick < 900; ++tick) {
        s.step();
        double bytes = 0.0;
        for (const mailbox::StatePacket& p : s.packets) {
            EXPECT_LE(p.body.size(), wire::kMaxDownBodyBytes);
            bytes += static_cast<double>(p.body.size() + kOverhead);
        }
        sent.push_back(bytes);
        over_budget += s.report.over_budget;
        if (tick > 100) {
            for (const auto& [entity, known] : s.remotes[0].model.known) {
                // 150 records of at most 40 bytes pass through 4000 bytes/s in 1.5 s; priorities by
                // age let none wait for much longer than that.
                EXPECT_GT(known.tick, s.world.now - 105) << entity.value;
            }
        }
    }
    EXPECT_GT(over_budget, 800U);
    // Any second holds at most a second's worth, the burst, and one packet's debt; the first one
    // the opening window instead of the burst.
    for (std::size_t begin = 0; begin + 30 <= sent.size(); ++begin) {
        double second = 0.0;
        for (std::size_t i = begin; i < begin + 30; ++i) {
            second += sent[i];
        }
        EXPECT_LE(second, 4000.0 + (begin == 0 ? 4000.0 : 1000.0) + 200.0);
    }
    s.world.freeze();
    for (int tick = 0; tick < 90; ++tick) {
        s.step();
    }
    s.expect_converged();
}

TEST(Replicator, ShowsANewClientItsSurroundingsNearestFirst) {
    ReplicationSettings settings = test_settings();
    settings.budget_bytes_per_s = 4000;
    Session s(31, settings, {}, 0, 400, 0, 20.0F);
    s.near = 1000.0F;  // one level of detail
    s.world.freeze();
    s.step();
    s.world.entities.set_client(0, ClientId(1));
    s.viewers.push_back({ClientId(1), s.world.entities.id[0]});
    s.remotes.emplace_back(ClientId(1), s.types, settings, NetSettings{}, 4);
    ClientTransfer transfer;
    transfer.client = ClientId(1);
    s.replicator.add_client(transfer);
    float farthest = 0.0F;
    std::set<EntityId> shown;
    int batches = 0;
    for (int tick = 0; tick < 150; ++tick) {
        s.step();
        float nearest_now = 1e9F;
        float farthest_now = 0.0F;
        for (const auto& [entity, known] : s.remotes[0].model.known) {
            if (shown.insert(entity).second) {
                const Vec3 offset = s.world.entities.position[s.world.entities.find(entity)] -
                                    s.world.entities.position[0];
                nearest_now = std::min(nearest_now, offset.norm());
                farthest_now = std::max(farthest_now, offset.norm());
            }
        }
        if (farthest_now > 0.0F) {
            EXPECT_GE(nearest_now, farthest) << tick;
            farthest = farthest_now;
            ++batches;
        }
    }
    EXPECT_GE(shown.size(), 350U);
    EXPECT_GT(batches, 5);
}

TEST(Replicator, AfterAnOutageOnlyWhatChangedIsSent) {
    ReplicationSettings settings = test_settings();
    Session s(32, settings, {}, 0, 200, 1, 20.0F);
    for (int tick = 0; tick < 60; ++tick) {
        s.step();
    }
    s.world.freeze();
    for (int tick = 0; tick < 90; ++tick) {
        s.step();
    }
    s.expect_converged();
    // Cut for five seconds, in both directions; three bodies move meanwhile.
    NetSettings cut;
    cut.loss = 1.0F;
    const NetSettings good = s.remotes[0].down.settings_;
    s.remotes[0].down.settings_ = cut;
    s.remotes[0].up.settings_ = cut;
    std::uint32_t lost_records = 0;
    std::uint32_t lost_packets = 0;
    for (int tick = 0; tick < 150; ++tick) {
        if (tick == 20) {
            for (world::Row row = 10; row < 13; ++row) {
                s.world.entities.position[row].x() += 1.0F;
            }
        }
        s.step();
        if (tick > 60) {
            lost_records += s.report.records_sent;
            lost_packets += s.report.packets;
        }
    }
    // When the server knows that no client hears, it sends nothing but signs of life.
    EXPECT_EQ(lost_records, 0U);
    EXPECT_GT(lost_packets, 0U);
    EXPECT_LT(lost_packets, 10U);
    s.remotes[0].down.settings_ = good;
    s.remotes[0].up.settings_ = good;
    std::uint32_t records = 0;
    for (int tick = 0; tick < 60; ++tick) {
        s.step();
        records += s.report.records_sent;
    }
    s.expect_converged();
    EXPECT_GE(records, 3U);
    // Each once, and its copies against loss; the outage did not make the network a bad one.
    EXPECT_LE(records, 3U * 4U);
}

TEST(Replicator, EncodesOncePerPublicationWhateverTheNumberOfSubscribers) {
    const auto publications = [](std::uint32_t clients) {
        Session s(13, test_settings(), {}, 30, 0, clients, 20.0F);
        s.near = 60.0F;
        std::uint32_t sum = 0;
        for (int tick = 0; tick < 300; ++tick) {
            s.step();
            sum += s.report.publications;
        }
        return sum;
    };
    // With one client the avatar of that client is published to no one: 29 streams instead of 30.
    const std::uint32_t two = publications(2);
    EXPECT_EQ(two, publications(20));
    EXPECT_GT(two, publications(1));
}

TEST(Replicator, GivesTheSameBytesForTheSameHistory) {
    const auto run = [] {
        core::StateHash hash;
        Session s(14, test_settings(), {0.1F, 0.1F, 2, 3}, 20, 20, 3, 40.0F);
        for (int tick = 0; tick < 300; ++tick) {
            s.step();
            for (const mailbox::StatePacket& p : s.packets) {
                hash.add(p.sequence);
                hash.add_bytes(p.body);
            }
        }
        s.replicator.hash(hash);
        return hash.value();
    };
    EXPECT_EQ(run(), run());
}

TEST(Replicator, SendsNothingButSignsOfLifeToTheSightless) {
    const world::TypeTable types = test_types();
    Replicator replicator(test_settings());
    world::Entities entities;
    std::vector<mailbox::StatePacket> packets;
    ReplicationReport report = replicator.step(1, kZone, entities, types, {}, {}, packets);
    EXPECT_TRUE(report.skipped);
    ClientTransfer transfer;
    transfer.client = ClientId(1);
    replicator.add_client(transfer);
    for (Tick tick = 2; tick < 62; ++tick) {
        report = replicator.step(tick, kZone, entities, types, {}, {}, packets);
        EXPECT_EQ(report.streams, 0U);
    }
    EXPECT_EQ(packets.size(), 5U);  // every 12 ticks: two and a half a second
}

TEST(Replicator, IgnoresAcksOfPacketsThatItNeverSent) {
    Session s(15, test_settings(), {}, 5, 0, 1, 10.0F);
    for (int tick = 0; tick < 50; ++tick) {
        s.replicator.on_acks({ClientId(1), ~std::uint64_t{0}, ~0U, 0});
        s.replicator.on_acks({ClientId(1), 0, ~0U, 0});
        s.replicator.on_acks({ClientId(77), 3, ~0U, 0});
        s.step();
    }
    s.world.freeze();
    for (int tick = 0; tick < 50; ++tick) {
        s.step();
    }
    s.expect_converged();
}

TEST(Replicator, TellsAViewerOfItsOwnAvatar) {
    Session s(16, test_settings(), {}, 2, 0, 1, 10.0F);
    s.own = {{ClientId(1), 0, false, 3}};
    int moving_ticks = 0;
    for (int tick = 0; tick < 120; ++tick) {
        s.own[0].input_tick = s.world.now + 1;
        s.step();
        if (tick == 60) {
            s.world.freeze();
        }
        ASSERT_TRUE(s.remotes[0].model.own.has_value());
        const wire::OwnState& own = *s.remotes[0].model.own;
        EXPECT_EQ(own.avatar, s.viewers[0].avatar);
        EXPECT_EQ(own.input_lead, 3);
        if (tick > 60 + 12) {
            EXPECT_EQ(own.state.position, s.world.entities.position[0]);
        } else if (s.world.entities.velocity[0].norm() > 0.0F) {
            moving_ticks = std::min(moving_ticks + 1, 100);
            EXPECT_GE(own.input_tick,
                      s.world.now - std::max<Tick>(s.settings.own_state_every_ticks,
                                                   s.settings.silence_ticks - moving_ticks));
        }
    }
}

/// Of ghosts, too: the zone that owns them may have no viewers.
TEST(Replicator, ReportsATruthThatExceedsItsDeclaredLimits) {
    for (const bool ghost : {false, true}) {
        Session s(17, test_settings(), {}, 3, 0, 1, 30.0F);
        s.world.spawn(kDasher);  // declared 5 m/s2 and jumps of 1 m/s, accelerates with 20 m/s2
        s.world.entities.set(s.world.entities.size() - 1, world::kGhost, ghost);
        std::uint32_t exceeded = 0;
        for (int tick = 0; tick < 300; ++tick) {
            s.step();
            exceeded += s.report.limit_exceeded;
        }
        EXPECT_GT(exceeded, 0U) << (ghost ? "a ghost" : "its own");
    }
}

TEST(Replicator, TellsOfASpinThatNoPredictionMayHaveMissed) {
    ReplicationSettings settings = test_settings();
    settings.lods = {{1000.0F, 3.2F}, {1000.0F, 3.2F}};  // nothing leaves its bound
    settings.forced_order = 1;
    settings.heartbeat_ticks = 1000;
    Session s(18, settings, {}, 1, 1, 1, 30.0F);
    const world::Row body = 1;
    const auto publications = [&] {
        std::uint32_t sum = 0;
        for (int tick = 0; tick < 5; ++tick) {
            s.world.entities.velocity[body].setZero();
            s.step();
            sum += s.report.publications;
        }
        return sum;
    };
    publications();
    const float most_rps = s.types[kBody].max_spin_jump_rps();
    s.world.entities.angular_velocity[body] += Vec3(0.0F, 0.9F * most_rps, 0.0F);
    EXPECT_EQ(publications(), 0U);
    s.world.entities.angular_velocity[body] += Vec3(0.0F, 0.2F * most_rps, 0.0F);
    EXPECT_EQ(publications(), 1U);
    EXPECT_EQ(publications(), 0U);
}

TEST(Replicator, RepeatsUpdatesOnlyWhereTheNetworkLoses) {
    const auto repeated = [](float loss) {
        NetSettings net;
        net.loss = loss;
        net.delay_ticks = 2;
        Session s(18, test_settings(), net, 20, 0, 2, 20.0F);
        std::uint32_t resent = 0, sent = 0;
        for (int tick = 0; tick < 600; ++tick) {
            s.step();
        }
        for (int tick = 0; tick < 600; ++tick) {
            s.step();
            resent += s.report.records_resent;
            sent += s.report.records_sent;
        }
        return static_cast<double>(resent) / sent;
    };
    EXPECT_EQ(repeated(0.0F), 0.0);
    EXPECT_GT(repeated(0.05F), 0.3);
}

}  // namespace
}  // namespace zoned::replication
