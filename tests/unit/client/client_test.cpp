#include "client-sim/link/client.h"

#include "tests/unit/client/fake_server.h"
#include "shared/core/rng.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <functional>
#include <string>
#include <vector>

namespace zoned::link {
namespace {

struct Recorder final : SessionHandler {
    void on_welcome(const wire::WelcomeMessage& welcome) override {
        ++welcomes;
        resumed += welcome.resumed ? 1 : 0;
    }

    void on_joined(const wire::JoinedMessage&) override { ++joins; }

    void on_event(const wire::EventMessage& event) override { events.push_back(event.event_id); }

    void on_audit(const wire::AuditRecordMessage&) override { ++audits; }

    bool on_packet(const OpenedPacket& packet) override {
        packets.push_back(packet.sequence);
        return !reads || reads(packet);
    }

    int welcomes = 0;
    int resumed = 0;
    int joins = 0;
    int audits = 0;
    std::vector<std::uint64_t> events;
    std::vector<std::uint64_t> packets;
    std::function<bool(const OpenedPacket&)> reads;  ///< empty: all
};

struct ClientTest : testing::Test {
    void make(const ConditionerSettings& path = {}) {
        server.emplace(path);
        client.emplace(*server, recorder, Login{});
        client->start(0.0);
    }

    void run_for(double seconds) {
        const double end = now + seconds;
        while (now < end) {
            now += 0.005;
            server->advance(now);
            client->advance(now);
            if (++loops % 6 == 0) {
                client->send_input({}, now);
            }
        }
    }

    std::optional<test::FakeServer> server;
    Recorder recorder;
    std::optional<Client> client;
    double now = 0.0;
    int loops = 0;
};

TEST(DatagramChannel, TellsTheServerOfWhatWasAcknowledgedAlone) {
    wire::SealKey down_key, up_key;
    down_key.key.fill(1);
    up_key.key.fill(2);
    DatagramChannel channel;
    channel.set_connection(5);
    channel.rekey(down_key, up_key);
    wire::Seal down(down_key), up(up_key);
    std::uint64_t sent = 0;
    const auto acks_now = [&](double now_s) {
        const Bytes datagram = channel.seal({}, now_s);
        const std::span<const std::uint8_t> all(datagram);
        std::vector<std::uint8_t> plain;
        EXPECT_TRUE(up.open(++sent,
                            all.first(wire::kDatagramHeaderBytes),
                            all.subspan(wire::kDatagramHeaderBytes),
                            plain));
        return *wire::read_up_transport(plain);
    };
    for (std::uint64_t sequence = 1; sequence <= 6; ++sequence) {
        std::vector<std::uint8_t> plain(wire::kDownTransportBytes);
        wire::write_transport(wire::DownTransport{}, plain.data());
        wire::DownHead head;
        head.tick = static_cast<Tick>(sequence);
        head.zone = ZoneId(1);
        wire::write_down_head(head, plain);
        Bytes datagram(wire::kDatagramHeaderBytes);
        wire::write_datagram_header({5, static_cast<std::uint16_t>(sequence)}, datagram.data());
        const Bytes header = datagram;
        down.seal(sequence, header, plain, datagram);
        const double now_s = 0.1 * static_cast<double>(sequence);
        const auto packet = channel.open(datagram, now_s);
        ASSERT_TRUE(packet);
        if (sequence == 2 || sequence == 4 || sequence == 5) {
            channel.acknowledge(*packet, now_s);
        }
        EXPECT_FALSE(channel.open(datagram, now_s)) << "read or not, it has come";
    }
    const wire::UpTransport told = acks_now(0.7);
    EXPECT_EQ(told.ack_low, 5);
    EXPECT_EQ(told.ack_bits, 0b101u);
    // Of the newest that is acknowledged: 0.2 s, in 10 us, cut off.
    EXPECT_NEAR(told.ack_delay_10us, 20000, 1);
}

TEST_F(ClientTest, LogsInHearsStatesAndSetsItsClock) {
    make();
    run_for(2.0);
    EXPECT_EQ(client->state(), SessionState::kOnline);
    EXPECT_EQ(recorder.welcomes, 1);
    EXPECT_EQ(recorder.joins, 1);
    EXPECT_GT(recorder.packets.size(), 50U);
    ASSERT_TRUE(client->clock().ready());
    // The fake delivers on the same step, so the round trip is the polling step of 5 ms at most.
    EXPECT_NEAR(client->clock().server_time(now), now + test::FakeServer::kClockOffsetS, 0.005);
    EXPECT_EQ(client->datagrams().unauthenticated, 0U);
}

TEST_F(ClientTest, EstimatesTheServerClockWithinHalfTheRoundTrip) {
    ConditionerSettings path;
    path.delay_s = 0.060;
    path.jitter_s = 0.020;
    make(path);
    run_for(5.0);
    const double error = client->clock().server_time(now) - (now + test::FakeServer::kClockOffsetS);
    EXPECT_LE(std::abs(error), client->clock().error_bound_s());
    EXPECT_NEAR(client->clock().rtt_s(), 0.125, 0.03);
}

TEST_F(ClientTest, AcknowledgesEventsInBatchesAndConfirmsWhereAsked) {
    make();
    run_for(0.5);
    for (std::uint64_t id = 1; id <= 50; ++id) {
        server->send_event(id << 16, id == 7);
    }
    run_for(0.5);
    EXPECT_EQ(recorder.events.size(), 50U);
    EXPECT_EQ(server->acked_events, 50U);
    EXPECT_EQ(server->confirmed, (std::set<std::uint64_t>{7U << 16}));
    int acks = 0;
    for (const auto& message : server->received) {
        acks += message.has_event_ack() ? 1 : 0;
    }
    EXPECT_LE(acks, 2);
}

TEST_F(ClientTest, DeliversEveryEventOnceAndInOrderOverManyReconnects) {
    ConditionerSettings path;
    path.delay_s = 0.020;
    path.jitter_s = 0.015;
    make(path);
    run_for(0.5);
    core::Rng rng(5);
    std::uint64_t next = 1;
    for (int round = 0; round < 20; ++round) {
        for (std::uint32_t i = rng.below(8); i > 0; --i) {
            server->send_event(next++ << 16);
        }
        run_for(0.01 * rng.below(10));
        server->cut();
        for (std::uint32_t i = rng.below(4); i > 0; --i) {
            server->send_event(next++ << 16);
        }
        run_for(1.0);
    }
    run_for(3.0);
    ASSERT_EQ(recorder.events.size(), next - 1);
    for (std::uint64_t id = 1; id < next; ++id) {
        EXPECT_EQ(recorder.events[id - 1], id << 16);
    }
    EXPECT_EQ(client->events().duplicated(), 0U);
    EXPECT_EQ(client->events().lost(), 0U);
    EXPECT_EQ(client->events().out_of_order(), 0U);
    EXPECT_EQ(recorder.welcomes, recorder.resumed + 1);
    EXPECT_EQ(recorder.resumed, 20);
}

TEST_F(ClientTest, CommandsAreCarriedOutOnceOverReconnects) {
    ConditionerSettings path;
    path.delay_s = 0.030;
    make(path);
    run_for(0.5);
    std::uint64_t sent = 0;
    for (int round = 0; round < 10; ++round) {
        for (int i = 0; i < 3; ++i) {
            client->send_command(1, "command " + std::to_string(++sent));
        }
        run_for(0.02);
        server->cut();  // before the acknowledgement, and partly before the command, came through
        client->send_command(1, "command " + std::to_string(++sent));
        run_for(1.0);
    }
    run_for(2.0);
    ASSERT_EQ(server->commands.size(), sent);
    for (std::uint64_t n = 1; n <= sent; ++n) {
        EXPECT_EQ(server->commands[n], "command " + std::to_string(n));
    }
    EXPECT_GT(client->stats().commands_resent, 0U);
}

TEST_F(ClientTest, CountsLostDoubledAndLateEvents) {
    make();
    run_for(0.5);
    server->send_raw_event(1, 100);
    server->send_raw_event(2, 200);
    server->send_raw_event(2, 200);  // doubled by number
    server->send_raw_event(3, 200);  // doubled by id
    server->send_raw_event(6, 600);  // 4 and 5 are missing
    server->send_raw_event(5, 500);  // 5 comes late
    run_for(0.2);
    EXPECT_EQ(client->events().delivered(), 4U);
    EXPECT_EQ(client->events().duplicated(), 2U);
    EXPECT_EQ(client->events().lost(), 1U);
    EXPECT_EQ(client->events().out_of_order(), 1U);
}

TEST_F(ClientTest, BeginsAnewWhenTheSessionIsGone) {
    make();
    run_for(0.5);
    server->send_event(1 << 16);
    run_for(0.2);
    server->accept_resume = false;
    server->cut();
    run_for(2.0);
    EXPECT_EQ(client->state(), SessionState::kOnline);
    EXPECT_EQ(client->stats().sessions_lost, 1U);
    const std::size_t before = recorder.packets.size();
    server->send_event(2 << 16);
    run_for(1.0);
    EXPECT_GT(recorder.packets.size(), before + 20);
    EXPECT_EQ(recorder.events.size(), 2U);
    EXPECT_EQ(client->events().lost(), 0U);
}

proto::Redirect redirect_to(const std::string& world, const std::string& ticket) {
    proto::Redirect redirect;
    redirect.set_world(world);
    redirect.set_host("other");
    redirect.set_tcp_port(4242);
    redirect.set_ticket(ticket);
    redirect.set_certificate_sha256("pin");
    return redirect;
}

TEST_F(ClientTest, GoesToTheWorldThatItsCharacterIsIn) {
    make();
    run_for(0.5);
    server->send_event(1 << 16);
    run_for(0.2);
    proto::ServerMessage message;
    message.mutable_closing()->set_reason(proto::CLOSING_ELSEWHERE);
    *message.mutable_closing()->mutable_redirect() = redirect_to("meadow", "t1");
    server->send(message);
    run_for(0.5);
    EXPECT_EQ(server->redirects, std::vector<std::string>{"other:4242/pin"});
    EXPECT_EQ(client->state(), SessionState::kOnline) << client->trouble();
    EXPECT_FALSE(client->on_its_way());
    EXPECT_EQ(client->stats().travels, 1U);
    ASSERT_EQ(client->stats().travel_gaps_s.size(), 1U);
    EXPECT_GT(client->stats().travel_gaps_s[0], 0.0);
    EXPECT_LT(client->stats().travel_gaps_s[0], 0.5);
    EXPECT_EQ(recorder.joins, 2);
    EXPECT_EQ(recorder.resumed, 0) << "it is another session";
    const auto hello = std::find_if(server->received.rbegin(),
                                    server->received.rend(),
                                    [](const auto& m) { return m.has_hello(); });
    ASSERT_NE(hello, server->received.rend());
    EXPECT_EQ(hello->hello().ticket(), "t1");
    EXPECT_EQ(hello->hello().world(), "meadow");
    EXPECT_TRUE(hello->hello().resume_token().empty());
    // Events count anew, and none is lost.
    server->send_raw_event(1, 7 << 16);
    run_for(0.2);
    EXPECT_EQ(client->events().lost(), 0U);
    EXPECT_EQ(client->events().duplicated(), 0U);
    EXPECT_TRUE(client->clock().ready());
}

TEST_F(ClientTest, ConnectsAheadToWhereItMaySoonGo) {
    make();
    run_for(0.5);
    proto::ServerMessage message;
    *message.mutable_ahead() = redirect_to("meadow", "");
    server->send(message);
    run_for(0.1);
    for (int port = 1; port < 50; ++port) {  // a server that has its clients knock on doors
        message.mutable_ahead()->set_tcp_port(static_cast<std::uint32_t>(port));
        server->send(message);
    }
    run_for(0.2);
    EXPECT_EQ(server->preparations, std::vector<std::string>{"other:4242/pin"});
    EXPECT_TRUE(server->redirects.empty()) << "it goes when it is told";
    run_for(2.0);
    message.mutable_ahead()->set_tcp_port(70'000);  // no port
    server->send(message);
    run_for(0.2);
    EXPECT_EQ(server->preparations.size(), 1U);
    EXPECT_EQ(client->state(), SessionState::kOnline);
    EXPECT_EQ(client->stats().travels, 0U);
}

TEST_F(ClientTest, AClientThatIsSentInACircleGivesUp) {
    make();
    run_for(0.5);
    server->refuse_elsewhere = true;
    proto::ServerMessage message;
    message.mutable_closing()->set_reason(proto::CLOSING_ELSEWHERE);
    *message.mutable_closing()->mutable_redirect() = redirect_to("meadow", "");
    server->send(message);
    run_for(5.0);
    EXPECT_EQ(client->state(), SessionState::kClosed);
    EXPECT_EQ(server->redirects.size(), 4U);
    EXPECT_NE(client->trouble().find("from server to server 4 times"), std::string::npos)
        << client->trouble();
}

TEST_F(ClientTest, ARedirectThatLeadsNowhereEndsTheSession) {
    for (const int broken : {0, 1, 2}) {
        make();
        server->takes_redirects = broken != 0;
        run_for(0.5);
        proto::ServerMessage message;
        message.mutable_closing()->set_reason(proto::CLOSING_ELSEWHERE);
        proto::Redirect redirect = redirect_to("meadow", "");
        redirect.set_tcp_port(broken == 1 ? 65536 : 4242);
        redirect.set_host(broken == 2 ? std::string("a\0\n", 3) : "other");
        *message.mutable_closing()->mutable_redirect() = redirect;
        server->send(message);
        run_for(0.5);
        EXPECT_EQ(client->state(), SessionState::kClosed) << broken;
        EXPECT_FALSE(client->trouble().empty());
        client.reset();
        now = 0.0;
    }
}

TEST_F(ClientTest, TunnelsThroughTheStreamWhereNoDatagramComes) {
    make();
    server->udp_blocked = true;
    run_for(4.0);
    EXPECT_TRUE(client->stats().tunnelled);
    EXPECT_GT(server->tunnelled_packets, 10);
    EXPECT_GT(recorder.packets.size(), 10U);
    // Where datagrams come through again, the client returns to them.
    server->udp_blocked = false;
    run_for(3.0);
    const int tunnelled = server->tunnelled_packets;
    run_for(1.0);
    EXPECT_EQ(server->tunnelled_packets, tunnelled);
}

TEST_F(ClientTest, DoesNotTunnelWhereTheServerIsSilentOnBothPaths) {
    make();
    run_for(1.0);
    server->stopped = true;
    run_for(6.0);
    server->stopped = false;
    run_for(3.0);
    EXPECT_FALSE(client->stats().tunnelled);
    const int inside = server->tunnelled_packets;
    run_for(1.0);
    EXPECT_EQ(server->tunnelled_packets, inside) << "the path is no longer asked";
}

TEST_F(ClientTest, ClosesForGoodWhenRefused) {
    make();
    server->refuse = true;
    run_for(1.0);
    EXPECT_EQ(client->state(), SessionState::kClosed);
    EXPECT_NE(client->trouble().find("refused"), std::string::npos);
    EXPECT_EQ(server->opens, 1);
}

TEST_F(ClientTest, ClosesForGoodWhereWelcomeHasNoKeys) {
    make();
    server->keyless = true;
    run_for(1.0);
    EXPECT_EQ(client->state(), SessionState::kClosed);
    EXPECT_EQ(client->trouble(), "the server's welcome has no keys for datagrams");
    EXPECT_EQ(recorder.welcomes, 0);
}

TEST_F(ClientTest, AcceptsEachDatagramOnce) {
    ConditionerSettings path;
    path.duplicate = 1.0;
    make(path);
    run_for(1.0);
    std::set<std::uint64_t> once(recorder.packets.begin(), recorder.packets.end());
    EXPECT_EQ(once.size(), recorder.packets.size());
    EXPECT_GE(client->datagrams().replayed, recorder.packets.size() - 1);
}

TEST_F(ClientTest, SurvivesHostileFramesAndDatagrams) {
    make();
    run_for(0.5);
    core::Rng rng(11);
    for (int i = 0; i < 3000; ++i) {
        Bytes junk(rng.below(200));
        for (auto& b : junk) {
            b = static_cast<std::uint8_t>(rng.next());
        }
        if (junk.size() >= 4 && rng.below(2) == 0) {
            junk[0] = test::FakeServer::kConnection;  // the right connection, a wrong seal
            junk[1] = junk[2] = junk[3] = 0;
        }
        server->send_raw_datagram(junk);
        server->send_raw_frame(junk);
        // An authentic packet with a damaged body.
        std::vector<std::uint8_t> body(rng.below(60));
        for (auto& b : body) {
            b = static_cast<std::uint8_t>(rng.next());
        }
        server->send_raw_datagram(server->seal_packet(body));
        if (i % 100 == 0) {
            run_for(0.01);
        }
    }
    run_for(0.5);
    EXPECT_EQ(client->state(), SessionState::kOnline);
    EXPECT_GT(client->datagrams().malformed + client->datagrams().unauthenticated, 2000U);
}

/// Acknowledgements reach back 33 packets. What none reaches back to would be sent again.
TEST_F(ClientTest, AcknowledgesAllThatItReadsAtOnceAfterAStall) {
    make();
    run_for(1.0);
    const std::uint64_t out = client->datagrams().out;
    const std::uint64_t in = client->datagrams().in;
    // The client stands still for two seconds, and then reads all that has come, before it sends.
    for (int i = 0; i < 400; ++i) {
        now += 0.005;
        server->advance(now);
    }
    client->advance(now);
    const std::uint64_t came = client->datagrams().in - in;
    ASSERT_GT(came, 40U);
    EXPECT_GE(client->datagrams().out - out, came / 16 - 1);
}

}  // namespace
}  // namespace zoned::link
