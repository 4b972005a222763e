#include "server/net/udp_endpoint.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <set>
#include <string>
#include <system_error>
#include <vector>

namespace zoned::net {
namespace {

using namespace std::chrono_literals;

UdpSettings local(const std::string& address, std::uint16_t port = 0) {
    UdpSettings settings;
    settings.bind_address = address;
    settings.port = port;
    return settings;
}

/// One end with its received datagrams.
struct End {
    End(asio::io_context& io, const UdpSettings& settings)
        : endpoint(io, settings, [this](std::span<const Datagram> batch) {
              largest_batch = std::max(largest_batch, batch.size());
              for (const Datagram& d : batch) {
                  from.push_back(d.from);
                  arrived_s.push_back(d.arrived_s);
                  payloads.emplace_back(d.bytes.begin(), d.bytes.end());
              }
          }) {
        endpoint.start();
    }

    std::vector<Address> from;
    std::vector<std::string> payloads;
    std::vector<double> arrived_s;
    std::size_t largest_batch = 0;
    UdpEndpoint endpoint;
};

std::span<const std::uint8_t> bytes_of(const std::string& s) {
    return {reinterpret_cast<const std::uint8_t*>(s.data()), s.size()};
}

void run_until(asio::io_context& io, const std::function<bool()>& done) {
    const auto end = std::chrono::steady_clock::now() + 5s;
    while (!done() && std::chrono::steady_clock::now() < end) {
        io.run_one_for(20ms);
    }
    EXPECT_TRUE(done());
}

/// A thousand datagrams to the server and back to where they came from.
void expect_round_trip(const std::string& bind, const std::string& target) {
    asio::io_context io;
    End server(io, local(bind));
    End client(io, local(target));
    const auto to = parse_address(target, server.endpoint.port());
    ASSERT_TRUE(to);
    for (int i = 0; i < 1000; ++i) {
        client.endpoint.queue_send(*to, bytes_of("datagram " + std::to_string(i)));
    }
    client.endpoint.flush();
    EXPECT_EQ(client.endpoint.stats().sent, 1000U);
    EXPECT_LE(client.endpoint.stats().send_calls,
              17U);  // 1,000 / 64, and the split at a full buffer
    run_until(io, [&] { return server.payloads.size() == 1000; });
    EXPECT_GT(server.largest_batch, 1U);
    EXPECT_EQ(server.payloads[7], "datagram 7");
    EXPECT_EQ(server.from[0].port, client.endpoint.port());
    EXPECT_TRUE(server.from[0].is_loopback());
    for (std::size_t i = 0; i < server.payloads.size(); ++i) {
        server.endpoint.queue_send(server.from[i], bytes_of(server.payloads[i]));
    }
    server.endpoint.flush();
    run_until(io, [&] { return client.payloads.size() == 1000; });
    EXPECT_EQ(client.payloads.back(), "datagram 999");
}

TEST(UdpEndpoint, CarriesBatchesOverIpv4) {
    expect_round_trip("127.0.0.1", "127.0.0.1");
}

TEST(UdpEndpoint, CarriesBatchesOverIpv6) {
    expect_round_trip("::1", "::1");
}

TEST(UdpEndpoint, ServesBothFamiliesOnOneSocket) {
    expect_round_trip("::", "127.0.0.1");
    expect_round_trip("::", "::1");
}

TEST(UdpEndpoint, NamesAddressAndPortWhenThePortIsInUse) {
    asio::io_context io;
    End first(io, local("127.0.0.1"));
    const std::uint16_t port = first.endpoint.port();
    try {
        End second(io, local("127.0.0.1", port));
        FAIL() << "the port was given out twice";
    } catch (const std::system_error& e) {
        EXPECT_EQ(e.code(), std::errc::address_in_use);
        EXPECT_THAT(e.what(), testing::HasSubstr("UDP 127.0.0.1:" + std::to_string(port)));
        EXPECT_THAT(e.what(), testing::HasSubstr("another program uses the port"));
    }
}

TEST(UdpEndpoint, SaysWhatIsWrongWithAnAddress) {
    asio::io_context io;
    EXPECT_THROW(End(io, local("not-an-address")), std::system_error);
    try {
        End end(io, local("192.0.2.1"));  // TEST-NET-1 (RFC 5737): no host has it
        FAIL();
    } catch (const std::system_error& e) {
        EXPECT_THAT(e.what(), testing::HasSubstr("this machine has no such address"));
    }
}

TEST(UdpEndpoint, CountsWhatItCannotSendAndGoesOn) {
    asio::io_context io;
    End client(io, local("127.0.0.1"));
    End server(io, local("127.0.0.1"));
    const auto good = parse_address("127.0.0.1", server.endpoint.port());
    const auto v6 = parse_address("::1", server.endpoint.port());
    const auto port_zero = parse_address("127.0.0.1", 0);
    client.endpoint.queue_send(*v6, bytes_of("from a v4 socket"));
    client.endpoint.queue_send(*good, bytes_of(std::string(UdpEndpoint::kMaxDatagram + 1, 'x')));
    client.endpoint.queue_send(*good, bytes_of("before"));
    client.endpoint.queue_send(*port_zero, bytes_of("refused by the kernel"));
    client.endpoint.queue_send(*good, bytes_of("after"));
    client.endpoint.flush();
    EXPECT_EQ(client.endpoint.stats().dropped_error, 3U);
    run_until(io, [&] { return server.payloads.size() == 2; });
    EXPECT_EQ(server.payloads, (std::vector<std::string>{"before", "after"}));
}

/// No datagram runs a handler meanwhile, nor makes the reactor look for one.
TEST(UdpEndpoint, LetsDatagramsWaitWhileItIsHeldAndKnowsWhenTheyCame) {
    asio::io_context io;
    End server(io, local("127.0.0.1"));
    End client(io, local("127.0.0.1"));
    const auto to = parse_address("127.0.0.1", server.endpoint.port());
    const auto send = [&](const std::string& text) {
        client.endpoint.queue_send(*to, bytes_of(text));
        client.endpoint.flush();
    };
    const auto now_s = [] {
        return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch())
            .count();
    };
    send("as it comes");
    run_until(io, [&] { return server.payloads.size() == 1; });
    server.endpoint.hold();
    const double before_s = now_s();
    send("held");
    send("held too");
    const double sent_s = now_s();
    EXPECT_EQ(io.run_for(50ms), 0U);
    EXPECT_EQ(server.payloads.size(), 1U);
    server.endpoint.read();
    ASSERT_EQ(server.payloads.size(), 3U);
    EXPECT_EQ(server.payloads.back(), "held too");
    EXPECT_EQ(server.largest_batch, 2U);
    // By the kernel's stamps; the two clocks are read one after the other.
    EXPECT_GT(server.arrived_s[1], before_s - 0.02);
    EXPECT_LT(server.arrived_s[1], sent_s + 0.02);
    EXPECT_LE(server.arrived_s[1], server.arrived_s[2]);
    send("waits");
    server.endpoint.watch();
    run_until(io, [&] { return server.payloads.size() == 4; });
    send("as it comes again");
    run_until(io, [&] { return server.payloads.size() == 5; });
}

TEST(UdpEndpoint, SurvivesItsOwnEndWithinACallback) {
    asio::io_context io;
    std::unique_ptr<UdpEndpoint> server;
    int calls = 0;
    server = std::make_unique<UdpEndpoint>(io, local("127.0.0.1"), [&](std::span<const Datagram>) {
        ++calls;
        server->close();
    });
    server->start();
    End client(io, local("127.0.0.1"));
    for (int i = 0; i < 200; ++i) {
        client.endpoint.queue_send(*parse_address("127.0.0.1", server->port()), bytes_of("x"));
    }
    client.endpoint.flush();
    run_until(io, [&] { return calls == 1; });
    io.run_for(20ms);
    EXPECT_EQ(calls, 1);
}

TEST(Address, KnowsItsFamilyLoopbackAndText) {
    const auto v4 = parse_address("127.9.0.1", 80);
    ASSERT_TRUE(v4);
    EXPECT_TRUE(v4->is_v4());
    EXPECT_TRUE(v4->is_loopback());
    EXPECT_EQ(text_of(*v4), "127.9.0.1:80");
    const auto v6 = parse_address("::1", 80);
    ASSERT_TRUE(v6);
    EXPECT_FALSE(v6->is_v4());
    EXPECT_TRUE(v6->is_loopback());
    EXPECT_EQ(text_of(*v6), "[::1]:80");
    EXPECT_FALSE(parse_address("2001:db8::1", 1)->is_loopback());
    EXPECT_FALSE(parse_address("10.0.0.1", 1)->is_loopback());
    EXPECT_FALSE(parse_address("localhost", 1));
}

}  // namespace
}  // namespace zoned::net
