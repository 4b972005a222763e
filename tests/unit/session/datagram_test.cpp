#include "server/session/datagrams/address_proof.h"
#include "tests/unit/session/fake_client.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <set>
#include <string>

namespace zoned::session {
namespace {

class Datagrams : public testing::Test {
  protected:
    Datagrams() {
        EXPECT_TRUE(client.log_in());
        host.advance(0.1);
    }

    std::vector<Tick> input_ticks() {
        std::vector<Tick> out;
        for (const auto& input : host.take<mailbox::Input>()) {
            for (const auto& command : input.commands) {
                out.push_back(command.tick);
            }
        }
        return out;
    }

    void deliver(const Bytes& bytes, std::uint16_t port = 1) {
        host.host.on_datagram(test_address(port), bytes, host.now_s);
    }

    TestHost host{dev_settings()};
    FakeClient client{host};
    std::uint64_t state_sequence_ = 0;
};

TEST_F(Datagrams, CarryCommandsToTheZonesOnce) {
    host.advance(0.1);
    const Tick t = host.tick + 1;
    client.send_datagram(commands_at(t, 3));
    client.send_datagram(commands_at(t + 1, 4));
    EXPECT_EQ(input_ticks(), (std::vector<Tick>{t, t + 1, t + 2, t + 3, t + 4}));
    EXPECT_TRUE(host.host.stats().rejected.empty());
    EXPECT_EQ(host.host.stats().packets_in, 2U);
}

TEST_F(Datagrams, HaveKeysOfTheirOwnOnEachStream) {
    std::set<std::string> keys;
    const auto note = [&](const FakeClient& one) {
        for (const std::string& key :
             {one.answer.welcome().datagram_key_down(), one.answer.welcome().datagram_key_up()}) {
            EXPECT_EQ(key.size(), wire::SealKey::kBytes);
            EXPECT_TRUE(keys.insert(key).second) << "a key was given twice";
        }
    };
    note(client);
    FakeClient other(host);
    ASSERT_TRUE(other.log_in());
    note(other);
    const Bytes before = client.make_datagram(1, commands_at(host.tick, 1));
    client.drop();
    ASSERT_TRUE(client.resume(0));
    note(client);
    deliver(before);
    EXPECT_EQ(host.rejected("not_authentic"), 1U);
    deliver(client.make_datagram(2, commands_at(host.tick, 1)));
    EXPECT_EQ(input_ticks().size(), 1U);
}

TEST_F(Datagrams, AreRefusedWhenReplayed) {
    const Bytes first = client.make_datagram(1, commands_at(host.tick, 1));
    deliver(first);
    deliver(first);
    deliver(first, 2);
    EXPECT_EQ(host.rejected("replayed"), 2U);
    // The window is 1,024 wide: an older datagram is refused although it was never seen.
    deliver(client.make_datagram(2000, {}));
    deliver(client.make_datagram(2000 - 1023, {}));
    EXPECT_EQ(host.rejected("replayed"), 2U);
    deliver(client.make_datagram(2000 - 1024, {}));
    EXPECT_EQ(host.rejected("replayed"), 3U);
}

TEST_F(Datagrams, AreRefusedWhenAnyBitWasChanged) {
    host.advance(0.1);
    const Bytes good = client.make_datagram(1, commands_at(host.tick, 2));
    for (std::size_t bit = 0; bit < good.size() * 8; ++bit) {
        Bytes bad = good;
        bad[bit / 8] = static_cast<std::uint8_t>(bad[bit / 8] ^ (1u << (bit % 8)));
        deliver(bad, 666);
    }
    EXPECT_TRUE(host.take<mailbox::Input>().empty());
    EXPECT_EQ(host.rejected("connection_unknown"), 32U);
    // One of the 16 bits of the sequence makes it 0, which is never valid.
    EXPECT_EQ(host.rejected("replayed") + host.rejected("not_authentic"), good.size() * 8 - 32);
    // No sender was answered, and the good one still counts as fresh.
    EXPECT_TRUE(host.datagrams.empty());
    deliver(good);
    EXPECT_EQ(input_ticks().size(), 2U);
}

TEST_F(Datagrams, AreRefusedWhenShortLongOrOfNoSession) {
    deliver(Bytes(21, 1));
    EXPECT_EQ(host.rejected("datagram_short"), 1U);
    deliver(Bytes());
    EXPECT_EQ(host.rejected("datagram_short"), 2U);
    deliver(Bytes(1201, 1));
    EXPECT_EQ(host.rejected("datagram_long"), 1U);
    Bytes stranger = client.make_datagram(1, {});
    stranger[0] = static_cast<std::uint8_t>(stranger[0] ^ 1u);
    deliver(stranger);
    EXPECT_EQ(host.rejected("connection_unknown"), 1U);
}

/// Otherwise a datagram caught on its way would move its session from UDP to the stream.
TEST_F(Datagrams, AreRefusedInTheStreamOfAnotherSession) {
    FakeClient other{host};
    ASSERT_TRUE(other.log_in(hello_message("bob")));
    const auto carried_by = [&](const FakeClient& carrier, std::uint64_t sequence) {
        const Bytes sealed = client.make_datagram(sequence, commands_at(host.tick, 1));
        proto::ClientMessage message;
        message.mutable_datagram()->set_sealed(sealed.data(), sealed.size());
        host.send(carrier.stream, message);
        return input_ticks().size();
    };
    EXPECT_EQ(carried_by(other, 1), 0U);
    EXPECT_EQ(host.rejected("connection_foreign"), 1U);
    EXPECT_EQ(carried_by(client, 2), 1U);
}

/// The timers of a process that was stopped run before its sockets are read.
TEST_F(Datagrams, ThatWaitWhileTheServerIsStoppedKeepTheirSessionAlive) {
    for (const double stall_s : {1.0, 3.0, 6.0, 20.0, 120.0}) {
        host.now_s += stall_s;
        host.host.tick(host.now_s, ++host.tick);
        client.send_datagram(commands_at(host.tick, 1));
        host.advance(1.0);
        client.send_datagram(commands_at(host.tick, 1));
        EXPECT_EQ(host.rejected("silence"), 0U) << stall_s;
        EXPECT_TRUE(host.closed.empty()) << stall_s;
    }
    host.advance(20.0);  // this is the client's silence
    EXPECT_EQ(host.rejected("silence"), 1U);
}

TEST_F(Datagrams, AndTheGraceTimeOutlastAStopOfTheServer) {
    client.drop();
    host.advance(1.0);
    host.now_s += 60.0;
    host.host.tick(host.now_s, ++host.tick);
    EXPECT_TRUE(client.resume(0));
}

TEST_F(Datagrams, AreCountedWhenTheyAuthenticateButMakeNoSense) {
    deliver(client.seal(1, Bytes(3, 0)));
    EXPECT_EQ(host.rejected("transport_malformed"), 1U);
    deliver(client.seal(2, Bytes(wire::kUpTransportBytes + 1, 0xFF)));
    EXPECT_EQ(host.rejected("body_malformed") + host.rejected("ack_ahead"), 2U);
}

TEST_F(Datagrams, MoveASessionToANewAddressOnlyWhenNewestAndAuthentic) {
    const auto target = [&] {
        client.state(++state_sequence_);
        EXPECT_FALSE(host.datagrams.empty());
        return host.datagrams.empty() ? 0 : host.datagrams.back().to.port;
    };
    deliver(client.make_datagram(5, {}), 10);
    EXPECT_EQ(target(), 10);
    deliver(client.make_datagram(4, {}), 20);  // authentic, but older
    EXPECT_EQ(target(), 10);
    Bytes forged = client.make_datagram(6, {});
    forged.back() = static_cast<std::uint8_t>(forged.back() ^ 1u);
    deliver(forged, 30);
    EXPECT_EQ(target(), 10);
    EXPECT_EQ(host.host.stats().address_changes, 0U);
    deliver(client.make_datagram(6, {}), 40);
    EXPECT_EQ(target(), 40);
    EXPECT_EQ(host.host.stats().address_changes, 1U);
    deliver(client.make_datagram(5, {}), 10);  // replayed
    EXPECT_EQ(target(), 40);
}

/// A client of one host that names another host's address, and states of 54 bytes.
class AnotherHost : public testing::Test {
  protected:
    AnotherHost() {
        client.peer = test_address(9);
        EXPECT_TRUE(client.log_in());
        far.ip[15] = 200;
    }

    /// So few at a time that none is paced. How many of them went out by UDP.
    std::size_t states(int count, double after_s = 1.0) {
        host.advance(after_s);
        const std::size_t before = host.datagrams.size();
        for (int i = 0; i < count; ++i) {
            client.state(++newest);
        }
        return host.datagrams.size() - before;
    }

    void from_far(std::uint16_t ack_low = 0) {
        wire::UpTransport transport;
        transport.ack_low = ack_low;
        const Bytes datagram = client.make_datagram(++client.sequence, {}, transport);
        came += datagram.size();
        host.host.on_datagram(far, datagram, host.now_s);
    }

    TestHost host{dev_settings()};
    FakeClient client{host};
    mailbox::Address far = test_address(11);
    std::uint64_t newest = 0;
    std::size_t came = 0;
};

TEST_F(AnotherHost, IsOneByItsAddressWhateverThePort) {
    client.send_datagram({}, 10);
    EXPECT_EQ(states(12), 12U);
}

TEST_F(AnotherHost, GetsThreeTimesWhatCameFromItUntilItAcknowledges) {
    client.send_datagram({}, 10);
    EXPECT_EQ(states(12), 12U);
    from_far();
    from_far();
    const std::size_t by_udp = states(12);
    std::size_t went = 0;
    for (std::size_t i = host.datagrams.size() - by_udp; i < host.datagrams.size(); ++i) {
        EXPECT_EQ(host.datagrams[i].to, far);
        went += host.datagrams[i].bytes.size();
    }
    EXPECT_GT(went, 2 * came);
    EXPECT_LE(went, AddressProof::kMostPerByte * came);
    EXPECT_EQ(host.host.stats().tunnelled, 12U - by_udp) << "the rest";
    EXPECT_EQ(host.rejected("out_unproved"), 0U);
    // A packet of before the move proves nothing; the first that went there, or a later one, does.
    from_far(12);
    EXPECT_LT(states(12), 12U);
    from_far(13);
    EXPECT_EQ(states(12), 12U);
}

TEST_F(AnotherHost, GetsNothingMoreWhereNoStreamIsLeft) {
    from_far();
    states(12);
    client.drop();
    from_far();
    const std::uint64_t before = host.rejected("out_unproved");
    const std::size_t by_udp = states(12, 0.5);
    EXPECT_LT(by_udp, 4U);
    EXPECT_EQ(host.rejected("out_unproved") - before, 12U - by_udp);
}

TEST_F(Datagrams, GoThroughTheStreamUntilOneCameByUdpAndAgainWhenTheClientSaysSo) {
    client.state(1);
    EXPECT_TRUE(host.datagrams.empty());
    ASSERT_FALSE(host.frames[client.stream].empty());
    const std::string tunnelled = host.frames[client.stream].back().datagram().sealed();
    EXPECT_TRUE(client.open(Bytes(tunnelled.begin(), tunnelled.end()), 1));
    EXPECT_EQ(host.host.stats().tunnelled, 1U);

    client.send_datagram({});
    client.state(2);
    ASSERT_EQ(host.datagrams.size(), 1U);
    EXPECT_TRUE(client.open(host.datagrams[0].bytes, 2));
    EXPECT_EQ(host.host.stats().packets_out, 1U);

    const Bytes up = client.make_datagram(++client.sequence, commands_at(host.tick, 1));
    proto::ClientMessage message;
    message.mutable_datagram()->set_sealed(up.data(), up.size());
    host.advance(0.1);
    host.send(client.stream, message);
    EXPECT_EQ(input_ticks().size(), 1U);
    client.state(3);
    EXPECT_EQ(host.datagrams.size(), 1U);
    EXPECT_EQ(host.host.stats().tunnelled, 2U);

    host.backlog = 1'000'000;
    client.state(4);
    EXPECT_EQ(host.host.stats().tunnelled, 2U);
    EXPECT_EQ(host.rejected("out_tunnel_backlog"), 1U);
}

/// A client that probes UDP sends its next datagram by the stream again, long before there is a
/// state.
TEST_F(Datagrams, AnswerAProbeByUdpThoughTheNextOneCameByTheStream) {
    const auto inside_stream = [&] {
        const Bytes up = client.make_datagram(++client.sequence, {});
        proto::ClientMessage message;
        message.mutable_datagram()->set_sealed(up.data(), up.size());
        host.advance(0.1);
        host.send(client.stream, message);
    };
    inside_stream();
    client.state(1);
    EXPECT_EQ(host.host.stats().tunnelled, 1U);
    client.send_datagram({});
    inside_stream();
    inside_stream();
    client.state(2);
    EXPECT_EQ(host.datagrams.size(), 1U);
    client.state(3);
    EXPECT_EQ(host.datagrams.size(), 1U) << "one answer, as the client did not come back";
    EXPECT_EQ(host.host.stats().tunnelled, 2U);
}

/// The other way round: a client that asks whether the stream still answers sends seven by UDP
/// after the one that asks.
TEST_F(Datagrams, AnswerOneThatAsksInTheStreamThoughTheNextOnesCameByUdp) {
    client.send_datagram({});
    client.state(1);
    EXPECT_EQ(host.datagrams.size(), 1U);
    const Bytes up = client.make_datagram(++client.sequence, {});
    proto::ClientMessage message;
    message.mutable_datagram()->set_sealed(up.data(), up.size());
    host.advance(0.1);
    host.send(client.stream, message);
    client.send_datagram({});
    client.send_datagram({});
    client.state(2);
    EXPECT_EQ(host.host.stats().tunnelled, 1U);
    client.state(3);
    EXPECT_EQ(host.datagrams.size(), 2U);
    EXPECT_EQ(host.host.stats().tunnelled, 1U);
}

TEST_F(Datagrams, AreNeverSealedTwiceUnderOneSequence) {
    client.send_datagram({});
    for (const std::uint64_t sequence : {1U, 2U, 2U, 1U, 5U, 4U, 5U, 6U}) {
        client.state(sequence);
    }
    EXPECT_EQ(host.datagrams.size(), 4U);
    EXPECT_EQ(host.rejected("out_sequence"), 4U);
    client.drop();
    ASSERT_TRUE(client.resume(0));
    client.send_datagram({});
    client.state(6);
    EXPECT_EQ(host.datagrams.size(), 4U);
    client.state(7);
    ASSERT_EQ(host.datagrams.size(), 5U);
    EXPECT_TRUE(client.open(host.datagrams.back().bytes, 7));
}

TEST_F(Datagrams, TooLongForOneDatagramAreNotSent) {
    client.send_datagram({});
    client.state(1, wire::kMaxDownBodyBytes);
    ASSERT_EQ(host.datagrams.size(), 1U);
    EXPECT_EQ(host.datagrams[0].bytes.size(), wire::kMaxDatagramBytes);
    client.state(2, wire::kMaxDownBodyBytes + 1);
    EXPECT_EQ(host.datagrams.size(), 1U);
    EXPECT_EQ(host.rejected("out_oversize"), 1U);
}

TEST_F(Datagrams, TellTheClockAndWhatArrived) {
    client.send_datagram({});
    client.sequence = 3;  // 2 and 3 are lost
    client.send_datagram({});
    host.now_s += 0.005;
    const double server_time_s = 5000.25;  // past 2^32 us
    host.host.on_outbox(
        mailbox::StatePacket{client.client, 1, Bytes(4, 0)}, host.now_s, server_time_s);
    const auto transport = client.open(host.datagrams.at(0).bytes, 1);
    ASSERT_TRUE(transport);
    EXPECT_EQ(transport->send_time_us, static_cast<std::uint32_t>(5000250000ULL));
    EXPECT_EQ(transport->ack_low, 4);
    EXPECT_EQ(transport->ack_bits, 0b100U);  // 4 - 1 - 2 = 1
    // 5 ms in steps of 10 us; the time is a double near 1000, exact to far below a step.
    EXPECT_NEAR(transport->ack_delay_10us, 500, 1);
}

TEST_F(Datagrams, BringAcksWithARoundTripThatLeavesOutTheClientsDelay) {
    client.send_datagram({});
    client.state(1);
    host.now_s += 0.060;
    wire::UpTransport transport;
    transport.ack_low = 1;
    client.send_datagram({}, 1, transport);
    client.state(2);
    host.now_s += 0.080;
    transport.ack_low = 2;
    transport.ack_bits = 1;
    transport.ack_delay_10us = 2000;  // 20 ms of the 80
    client.send_datagram({}, 1, transport);
    const auto acks = host.take<mailbox::Acks>();
    ASSERT_EQ(acks.size(), 2U);
    EXPECT_EQ(acks[1].newest, 2U);
    EXPECT_EQ(acks[1].bits, 1U);
    EXPECT_NEAR(acks[1].rtt_us, 60'000.0, 1.0);
    EXPECT_NEAR(host.host.rtt_percentiles().p50_ms, 60.0, 0.001);
    EXPECT_EQ(host.host.rtt_percentiles().sessions, 1U);
    EXPECT_EQ(host.rejected("ack_ahead"), 0U);
    // A repeated acknowledgement has no effect; one of a packet that was never sent is refused.
    client.send_datagram({}, 1, transport);
    EXPECT_TRUE(host.take<mailbox::Acks>().empty());
    transport.ack_low = 3;
    client.send_datagram({}, 1, transport);
    EXPECT_TRUE(host.take<mailbox::Acks>().empty());
    EXPECT_EQ(host.rejected("ack_ahead"), 1U);
}

TEST_F(Datagrams, AcknowledgeNothingBeforeTheFirst) {
    wire::UpTransport transport;
    transport.ack_bits = 1;
    client.send_datagram({}, 1, transport);
    EXPECT_EQ(host.rejected("ack_ahead"), 1U);
    client.state(1);
    client.state(2);
    transport.ack_low = 2;
    transport.ack_bits = 0xFFFFFFFF;
    client.send_datagram({}, 1, transport);
    const auto acks = host.take<mailbox::Acks>();
    ASSERT_EQ(acks.size(), 1U);
    EXPECT_EQ(acks[0].bits, 1U);
}

TEST_F(Datagrams, KeepTheirSequencesBeyondSixteenBits) {
    for (std::uint64_t s = 1; s < 200'000; s += 700) {
        deliver(client.make_datagram(s, {}));
        client.state(s);
        ASSERT_FALSE(host.datagrams.empty());
        ASSERT_TRUE(client.open(host.datagrams.back().bytes, s));
        wire::UpTransport transport;
        transport.ack_low = static_cast<std::uint16_t>(s);
        deliver(client.make_datagram(s + 1, {}, transport));
        const auto acks = host.take<mailbox::Acks>();
        ASSERT_EQ(acks.size(), 1U) << s;
        ASSERT_EQ(acks[0].newest, s);
        host.advance(0.05);
    }
}

TEST_F(Datagrams, AreLimitedPerSecondOnlyAfterTheyAuthenticated) {
    Bytes forged = client.make_datagram(1, {});
    forged.back() = static_cast<std::uint8_t>(forged.back() ^ 1u);
    for (int i = 0; i < 1000; ++i) {
        deliver(forged);
    }
    EXPECT_EQ(host.rejected("datagram_flood"), 0U);  // a forger cannot use up the client's share
    for (int i = 0; i < 200; ++i) {
        client.send_datagram({});
    }
    EXPECT_EQ(host.rejected("datagram_flood"), 80U);  // 120 are the burst
}

TEST_F(Datagrams, GoOnWithoutAStreamAsLongAsTheClientIsHeard) {
    client.send_datagram({});
    client.drop();
    client.state(1);
    EXPECT_EQ(host.datagrams.size(), 1U);
    host.advance(1.5);
    client.state(2);
    EXPECT_EQ(host.datagrams.size(), 1U);
    EXPECT_EQ(host.rejected("out_suspended"), 1U);
    client.send_datagram(commands_at(host.tick, 1), 9);
    EXPECT_EQ(input_ticks().size(), 1U);
    client.state(3);
    ASSERT_EQ(host.datagrams.size(), 2U);
    EXPECT_EQ(host.datagrams[1].to.port, 9);
}

/// The zones make no packets for a session that has nowhere to send them.
TEST_F(Datagrams, AreAskedOfTheZonesOnlyWhereTheyHaveSomewhereToGo) {
    const auto reach = [&] {
        std::string all;
        for (const mailbox::Reach& one : host.take<mailbox::Reach>()) {
            EXPECT_EQ(one.client, client.client);
            all += one.on ? '+' : '-';
        }
        return all;
    };
    client.send_datagram({});
    host.advance(0.1);
    client.drop();
    host.advance(0.5);
    EXPECT_EQ(reach(), "") << "it is still heard by UDP";
    host.advance(1.0);
    EXPECT_EQ(reach(), "-");
    host.advance(1.0);
    EXPECT_EQ(reach(), "") << "once is enough";
    client.send_datagram(commands_at(host.tick, 1));
    EXPECT_EQ(reach(), "+");
    host.advance(1.5);
    EXPECT_EQ(reach(), "-");
    ASSERT_TRUE(client.resume(0));
    EXPECT_EQ(reach(), "+");
}

/// RFC 9002, section 5.3: a client that claims to have kept an acknowledgement back for longer than
/// the path explains does not make the path shorter than it ever was.
TEST_F(Datagrams, BelieveNoDelayThatMakesTheRoundTripShorterThanTheShortest) {
    client.send_datagram({});
    wire::UpTransport transport;
    for (std::uint64_t sequence = 1; sequence <= 40; ++sequence) {
        client.state(sequence);
        host.now_s += 0.050;
        transport.ack_low = static_cast<std::uint16_t>(sequence);
        transport.ack_bits = ~0U;
        transport.ack_delay_10us = sequence > 10 ? 4900 : 0;
        client.send_datagram({}, 1, transport);
    }
    const auto acks = host.take<mailbox::Acks>();
    ASSERT_EQ(acks.size(), 40U);
    EXPECT_NEAR(acks.back().rtt_us, 50'000.0, 1.0);
    EXPECT_NEAR(acks.front().rtt_variation_us, 25'000.0, 1.0);
    EXPECT_LT(acks.back().rtt_variation_us, 10U);
}

/// A server that is behind reads what is fresh. A forged datagram takes the place of none.
TEST_F(Datagrams, ThatWaitedTogetherAreReadFromTheNewestOnAndOnlyAFew) {
    std::vector<Bytes> waiting;
    for (int i = 1; i <= 20; ++i) {
        waiting.push_back(client.make_datagram(++client.sequence, commands_at(host.tick + i, 1)));
    }
    Bytes forged = waiting.back();
    forged.back() ^= 1U;
    waiting.push_back(forged);
    host.host.begin_datagrams();
    for (auto datagram = waiting.rbegin(); datagram != waiting.rend(); ++datagram) {
        deliver(*datagram);
    }
    EXPECT_EQ(host.rejected("not_authentic"), 1U);
    EXPECT_EQ(host.rejected("datagram_overtaken"), 17U);
    const Tick newest = host.tick + 20;
    EXPECT_EQ(input_ticks(), (std::vector<Tick>{newest, newest - 1, newest - 2}));
    host.host.begin_datagrams();
    deliver(client.make_datagram(++client.sequence, commands_at(host.tick + 21, 1)));
    EXPECT_EQ(input_ticks().size(), 1U);
}

/// A client may send as many as its limit in the time for which they were left to wait.
TEST_F(Datagrams, ThatWereLeftToWaitAreReadAsFarAsTheLimitOfTheirTimeGoes) {
    std::vector<Bytes> waiting;
    for (int i = 1; i <= 20; ++i) {
        waiting.push_back(client.make_datagram(++client.sequence, commands_at(host.tick + i, 1)));
    }
    const double gathered_s = 5.0 / dev_settings().max_datagrams_per_s;
    host.host.begin_datagrams(gathered_s);
    for (auto datagram = waiting.rbegin(); datagram != waiting.rend(); ++datagram) {
        deliver(*datagram);
    }
    EXPECT_EQ(input_ticks().size(), 8U);
    EXPECT_EQ(host.rejected("datagram_overtaken"), 12U);
}

/// Waiting in the socket is no part of the path: neither of the server's measurement nor, by the
/// delay that it reports, of the client's.
TEST_F(Datagrams, AreTimedByTheirArrivalAndNotByTheirReading) {
    client.send_datagram({});
    for (std::uint64_t sequence = 1; sequence <= 20; ++sequence) {
        client.state(sequence);
        wire::UpTransport transport;
        transport.ack_low = static_cast<std::uint16_t>(sequence);
        const Bytes datagram = client.make_datagram(++client.sequence, {}, transport);
        host.now_s += 0.050;
        host.host.on_datagram(test_address(1), datagram, host.now_s, host.now_s - 0.040);
    }
    const auto acks = host.take<mailbox::Acks>();
    ASSERT_EQ(acks.size(), 20U);
    EXPECT_NEAR(acks.back().rtt_us, 10'000.0, 1.0);
    host.datagrams.clear();
    client.state(21);
    const auto down = client.open(host.datagrams.at(0).bytes, 21);
    ASSERT_TRUE(down);
    EXPECT_NEAR(down->ack_delay_10us, 4000, 1);
}

TEST_F(Datagrams, OfTheOldKeysNoLongerOpenAfterTheClientCameBack) {
    const Bytes old = client.make_datagram(++client.sequence, commands_at(host.tick, 1));
    client.drop();
    ASSERT_TRUE(client.resume(0));
    deliver(old);
    EXPECT_EQ(host.rejected("not_authentic"), 1U);
    client.send_datagram(commands_at(host.tick, 1));
    EXPECT_EQ(input_ticks().size(), 1U);
}

TEST_F(Datagrams, OfOneTickLeaveSpreadOutAndInOrder) {
    FakeClient other{host};
    ASSERT_TRUE(other.log_in());
    client.send_datagram({}, 1);
    other.send_datagram({}, 2);
    host.datagrams.clear();
    constexpr std::uint64_t kPackets = 4;
    for (std::uint64_t n = 1; n <= kPackets; ++n) {
        client.state(n, 1000);
        other.state(n, 1000);
    }
    // The first of each goes at once, the others when the path can take them.
    EXPECT_EQ(host.datagrams.size(), 2U);
    const double began_s = host.now_s;
    while (host.host.next_release_s() < began_s + 1.0) {
        const double next_s = host.host.next_release_s();
        ASSERT_GE(next_s, host.now_s);
        host.now_s = next_s;
        host.host.release(host.now_s, host.now_s);
    }
    EXPECT_LT(host.now_s, began_s + 1.0 / 30.0);
    ASSERT_EQ(host.datagrams.size(), 2 * kPackets);
    std::uint64_t opened = 0;
    std::uint64_t opened_other = 0;
    for (const SentDatagram& sent : host.datagrams) {
        const bool mine = client.open(sent.bytes, opened + 1).has_value();
        (mine ? opened : opened_other) += 1;
        EXPECT_TRUE(mine || other.open(sent.bytes, opened_other).has_value());
    }
    EXPECT_EQ(opened, kPackets);
    EXPECT_EQ(opened_other, kPackets);
}

TEST_F(Datagrams, OfTheTickBeforeLeaveBeforeNewOnes) {
    client.send_datagram({});
    host.datagrams.clear();
    client.state(1, 1000);
    client.state(2, 1000);
    EXPECT_EQ(host.datagrams.size(), 1U);
    host.now_s += 1.0;
    client.state(3, 20);
    ASSERT_EQ(host.datagrams.size(), 3U);
    for (std::uint64_t n = 1; n <= 3; ++n) {
        EXPECT_TRUE(client.open(host.datagrams[n - 1].bytes, n)) << n;
    }
    // When the one that went before its time would have been due, nothing is left to send.
    host.host.release(host.now_s, host.now_s);
    EXPECT_EQ(host.datagrams.size(), 3U);
    EXPECT_TRUE(host.host.stats().rejected.empty());
}

TEST_F(Datagrams, OfASessionThatEndedMeanwhileAreCounted) {
    client.send_datagram({});
    client.state(1, 1000);
    client.state(2, 1000);
    proto::ClientMessage quit;
    quit.mutable_quit();
    host.send(client.stream, quit);
    host.now_s += 1.0;
    host.host.release(host.now_s, host.now_s);
    EXPECT_EQ(host.rejected("out_no_session"), 1U);
}

}  // namespace
}  // namespace zoned::session
