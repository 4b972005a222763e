// SocketTransport against the server's own sockets, on loopback.
#include "client-sim/link/socket_transport.h"

#include "client-sim/link/conditioned_network.h"
#include "server/net/tls_listener.h"
#include "server/net/udp_endpoint.h"
#include "shared/wire/packet.h"

#include <gtest/gtest.h>

#include <chrono>
#include <filesystem>
#include <map>
#include <thread>

namespace zoned::link {
namespace {

Bytes bytes_of(const std::string& text) {
    return {text.begin(), text.end()};
}

/// A shorter datagram can't be one of ours.
constexpr std::size_t kText = 40;

std::string padded(std::string text) {
    text.resize(kText, '.');
    return text;
}

/// A datagram of a connection, as far as transports look into it.
Bytes datagram_of(std::uint32_t connection, const std::string& text) {
    Bytes out(wire::kDatagramHeaderBytes);
    wire::write_datagram_header({connection, 1}, out.data());
    const std::string body = padded(text);
    out.insert(out.end(), body.begin(), body.end());
    return out;
}

/// Sends back every frame and every datagram.
class Echo {
  public:
    Echo() {
        std::string pattern = testing::TempDir() + "zoned-transport-XXXXXX";
        folder_ = mkdtemp(pattern.data());
        net::TlsSettings tls;
        tls.bind_address = "127.0.0.1";
        tls.certificate.state_dir = folder_;
        net::TlsCallbacks callbacks;
        callbacks.on_open = [](auto&&...) {
        };
        callbacks.on_frame = [this](net::StreamNumber n, std::span<const std::uint8_t> frame) {
            listener->send(n, frame);
            if (std::string(frame.begin(), frame.end()) == "close") {
                listener->close(n);
            }
        };
        callbacks.on_closed = [this](net::StreamNumber, const std::string& reason) {
            closed.push_back(reason);
        };
        listener = std::make_unique<net::TlsListener>(io, tls, callbacks);
        listener->start();
        net::UdpSettings udp;
        udp.bind_address = "127.0.0.1";
        endpoint = std::make_unique<net::UdpEndpoint>(
            io, udp, [this](std::span<const net::Datagram> datagrams) {
                for (const net::Datagram& d : datagrams) {
                    endpoint->queue_send(d.from, d.bytes);
                    // Of a connection that does not exist here: must reach no client.
                    endpoint->queue_send(d.from, datagram_of(999, "stray"));
                }
                endpoint->flush();
            });
        endpoint->start();
    }

    ~Echo() {
        listener->abort_all();
        endpoint->close();
        std::filesystem::remove_all(folder_);
    }

    Echo(const Echo&) = delete;
    Echo& operator=(const Echo&) = delete;

    asio::io_context io;
    std::unique_ptr<net::TlsListener> listener;
    std::unique_ptr<net::UdpEndpoint> endpoint;
    std::vector<std::string> closed;

  private:
    std::string folder_;
};

/// The frames and datagrams that one client received.
struct Heard {
    bool opened = false;
    std::vector<std::string> frames;
    std::vector<std::string> datagrams;
    std::vector<std::string> closed;
};

class SocketTransportTest : public testing::Test {
  protected:
    NetworkSettings settings() {
        NetworkSettings s;
        s.host = "127.0.0.1";
        s.port = std::to_string(echo.listener->port());
        s.trust.kind = Trust::TrustKind::kInsecure;
        s.udp_sockets = 2;
        return s;
    }

    void listen(Transport& transport, Heard& heard) {
        TransportEvents events;
        events.opened = [&heard](bool inside) {
            heard.opened = !inside;
        };
        events.frame = [&heard](Bytes frame) {
            heard.frames.emplace_back(frame.begin(), frame.end());
        };
        events.datagram = [&heard](Bytes datagram) {
            heard.datagrams.emplace_back(datagram.begin() + wire::kDatagramHeaderBytes,
                                         datagram.end());
        };
        events.closed = [&heard](std::string reason) {
            heard.closed.push_back(std::move(reason));
        };
        transport.set_events(std::move(events));
    }

    /// Drives both sides until `done`; the network's clock goes on by a millisecond a turn.
    template <class Network, class Done>
    bool drive(Network& network, Done&& done) {
        const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(20);
        while (!done()) {
            if (std::chrono::steady_clock::now() > end) {
                return false;
            }
            echo.io.restart();
            echo.io.poll();
            now_s += 0.001;
            network.poll(now_s);
            network.flush();
            std::this_thread::sleep_for(std::chrono::microseconds(200));
        }
        return true;
    }

    Echo echo;
    double now_s = 0.0;
};

TEST_F(SocketTransportTest, OpensAStreamWithUdpBesideIt) {
    SocketNetwork network(settings());
    EXPECT_TRUE(network.loopback());
    EXPECT_EQ(network.header_bytes(), 28);
    Heard heard;
    const auto transport = network.make_transport();
    listen(*transport, heard);
    transport->open();
    ASSERT_TRUE(drive(network, [&] { return heard.opened; }));
}

TEST_F(SocketTransportTest, CarriesFramesOfAllSizesInOrder) {
    SocketNetwork network(settings());
    Heard heard;
    const auto transport = network.make_transport();
    listen(*transport, heard);
    transport->open();
    // Sent before the stream is up: kept until then.
    std::vector<std::string> sent;
    for (const std::size_t size : {0u, 1u, 100u, 5000u, 60000u}) {
        sent.emplace_back(size, static_cast<char>('a' + size % 26));
        transport->send_frame(bytes_of(sent.back()));
    }
    ASSERT_TRUE(drive(network, [&] { return heard.frames.size() == sent.size(); }));
    EXPECT_EQ(heard.frames, sent);
}

TEST_F(SocketTransportTest, HandsDatagramsToTheClientThatTheyAreFor) {
    SocketNetwork network(settings());
    Heard heard[3];
    std::vector<std::unique_ptr<SocketTransport>> transports;
    // Three clients on two sockets.
    for (std::uint32_t i = 0; i < 3; ++i) {
        transports.push_back(network.make_transport());
        listen(*transports.back(), heard[i]);
        transports.back()->send_datagram(datagram_of(70 + i, "nowhere to go yet"));
        transports.back()->set_udp(echo.endpoint->port(), 70 + i);
        transports.back()->send_datagram(datagram_of(70 + i, "to " + std::to_string(i)));
    }
    ASSERT_TRUE(drive(network, [&] {
        return std::all_of(std::begin(heard), std::end(heard), [](const Heard& h) {
            return !h.datagrams.empty();
        });
    }));
    for (std::uint32_t i = 0; i < 3; ++i) {
        EXPECT_EQ(heard[i].datagrams, std::vector<std::string>{padded("to " + std::to_string(i))});
    }
    // A client that is gone receives nothing, and no other client receives its datagrams.
    transports[1]->send_datagram(datagram_of(71, "late"));
    transports[1].reset();
    transports[2]->send_datagram(datagram_of(72, "on time"));
    ASSERT_TRUE(drive(network, [&] { return heard[2].datagrams.size() == 2; }));
    EXPECT_EQ(heard[1].datagrams.size(), 1u);
    EXPECT_EQ(heard[2].datagrams[1], padded("on time"));
}

TEST_F(SocketTransportTest, HearsLastWordsAndThenTheEnd) {
    SocketNetwork network(settings());
    Heard heard;
    const auto transport = network.make_transport();
    listen(*transport, heard);
    transport->open();
    transport->send_frame(bytes_of("close"));
    ASSERT_TRUE(drive(network, [&] { return !heard.closed.empty(); }));
    EXPECT_EQ(heard.frames, std::vector<std::string>{"close"});
    EXPECT_EQ(heard.closed, std::vector<std::string>{""}) << "in order";
    // And it can be opened again.
    heard = {};
    transport->open();
    transport->send_frame(bytes_of("again"));
    ASSERT_TRUE(drive(network, [&] { return !heard.frames.empty(); }));
    EXPECT_EQ(heard.frames[0], "again");
    transport->close();
    ASSERT_TRUE(drive(network, [&] { return echo.closed.size() == 2; }));
    EXPECT_TRUE(heard.closed.empty()) << "who closes needs no word of it";
}

TEST_F(SocketTransportTest, SaysWhyItCannotConnect) {
    NetworkSettings nowhere = settings();
    nowhere.port = "1";
    SocketNetwork network(nowhere);
    Heard heard;
    const auto transport = network.make_transport();
    listen(*transport, heard);
    transport->open();
    ASSERT_TRUE(drive(network, [&] { return !heard.closed.empty(); }));
    EXPECT_NE(heard.closed[0].find("cannot connect"), std::string::npos) << heard.closed[0];
    NetworkSettings nobody = settings();
    nobody.host = "no-such-host.invalid";
    EXPECT_NE(SocketNetwork(nobody).trouble().find("cannot resolve no-such-host.invalid"),
              std::string::npos);
}

TEST_F(SocketTransportTest, TrustsTheRightCertificateOnly) {
    const auto outcome = [&](const NetworkSettings& s) {
        SocketNetwork network(s);
        Heard heard;
        const auto transport = network.make_transport();
        listen(*transport, heard);
        transport->open();
        EXPECT_TRUE(drive(network, [&] { return heard.opened || !heard.closed.empty(); }));
        return heard.opened ? std::string("opened") : heard.closed[0];
    };
    NetworkSettings s = settings();
    s.trust.kind = Trust::TrustKind::kPin;
    s.trust.pin.assign(32, 0);
    EXPECT_NE(outcome(s).find("not the pinned one"), std::string::npos);
    s.trust.kind = Trust::TrustKind::kVerify;
    EXPECT_NE(outcome(s).find("TLS handshake failed"), std::string::npos);
    s.ca_file = echo.listener->certificate_files().certificate;
    EXPECT_EQ(outcome(s), "opened");
    s.ca_file = "/nonexistent.pem";
    EXPECT_NE(SocketNetwork(s).trouble().find("certificate authorities in /nonexistent.pem"),
              std::string::npos);
}

TEST_F(SocketTransportTest, HoldsBackAndLosesWhatTheConditionerSays) {
    ConditionerSettings slow;
    slow.delay_s = 0.5;
    slow.loss = 1.0;
    ConditionedNetwork network(settings(), slow);
    Heard heard;
    const auto transport = network.make_transport();
    listen(*transport, heard);
    transport->open();
    transport->set_udp(echo.endpoint->port(), 5);
    ASSERT_TRUE(drive(network, [&] { return heard.opened; }));
    const double begun = now_s;
    transport->send_frame(bytes_of("slow"));
    transport->send_datagram(datagram_of(5, "lost"));
    ASSERT_TRUE(drive(network, [&] { return !heard.frames.empty(); }));
    // Half a second in each direction on the clock that was passed in.
    EXPECT_GE(now_s - begun, 1.0);
    EXPECT_TRUE(heard.datagrams.empty());
}

}  // namespace
}  // namespace zoned::link
