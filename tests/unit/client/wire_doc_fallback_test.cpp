// proto/WIRE.md agrees with the client library about when datagrams go inside the stream.
#include "client-sim/link/client.h"
#include "tests/unit/client/fake_server.h"
#include "tests/unit/wire/wire_document.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <functional>
#include <string>
#include <utility>
#include <vector>

namespace zoned::link {
namespace {

/// Passes all on to a server, and notes how each datagram of the client went.
class PathNotes final : public Transport {
  public:
    void set_events(TransportEvents events) override { server.set_events(std::move(events)); }

    void open() override { server.open(); }

    void send_frame(Bytes frame) override {
        constexpr std::uint8_t kDatagramTag = 0x4A;  // field 9 of ClientMessage
        if (frame.at(0) == kDatagramTag) {
            inside.push_back(true);
            at_s.push_back(now_s);
        }
        server.send_frame(std::move(frame));
    }

    void set_udp(std::uint16_t port, std::uint32_t connection) override {
        server.set_udp(port, connection);
    }

    void send_datagram(Bytes datagram) override {
        inside.push_back(false);
        at_s.push_back(now_s);
        server.send_datagram(std::move(datagram));
    }

    void close() override { server.close(); }

    test::FakeServer server;
    double now_s = 0.0;
    std::vector<bool> inside;
    std::vector<double> at_s;
};

struct Listener final : SessionHandler {
    void on_welcome(const wire::WelcomeMessage& /*welcome*/) override {}

    void on_joined(const wire::JoinedMessage& /*joined*/) override {}

    void on_event(const wire::EventMessage& /*event*/) override {}

    void on_audit(const wire::AuditRecordMessage& /*record*/) override {}

    bool on_packet(const OpenedPacket& /*packet*/) override { return true; }
};

constexpr double kLook = 0.005;   // s between two looks of the client
constexpr int kSendEvery = 6;     // looks
constexpr double kLatest = 0.12;  // what a look, a tick of the server and two datagrams take

struct WireDocumentFallback : testing::Test {
    WireDocumentFallback() {
        const auto all = wire::testing::examples_named("fallback");
        EXPECT_EQ(all.size(), 1U);
        said = all.at(0);
        client.start(0.0);
    }

    void run_for(double seconds) {
        const double end = path.now_s + seconds;
        while (path.now_s < end) {
            path.now_s += kLook;
            path.server.advance(path.now_s);
            client.advance(path.now_s);
            if (++looks % kSendEvery == 0) {
                client.send_input({}, path.now_s);
            }
        }
    }

    [[nodiscard]] double number(const std::string& key) const { return said.numbers(key).at(0); }

    /// From the datagram `first` on, each `period`-th goes as `rare` says and no other.
    void expect_one_in(std::size_t first, std::size_t period, bool rare) const {
        std::vector<std::size_t> found;
        for (std::size_t i = first; i < path.inside.size(); ++i) {
            if (path.inside[i] == rare) {
                found.push_back(i);
            }
        }
        ASSERT_GE(found.size(), 3U);
        EXPECT_LE(found.front() - first, period);
        for (std::size_t i = 1; i < found.size(); ++i) {
            EXPECT_EQ(found[i] - found[i - 1], period) << "at datagram " << found[i];
        }
    }

    [[nodiscard]] std::size_t first_inside() const {
        const auto it = std::find(path.inside.begin(), path.inside.end(), true);
        EXPECT_NE(it, path.inside.end());
        return static_cast<std::size_t>(it - path.inside.begin());
    }

    wire::testing::Example said;
    PathNotes path;
    Listener listener;
    Client client{path, listener, Login{}};
    int looks = 0;
};

TEST_F(WireDocumentFallback, AsksInsideTheStreamAfterSilenceAndOneInSoMany) {
    run_for(1.0);
    path.server.stopped = true;
    const double silent_s = path.now_s;
    run_for(8.0);
    const std::size_t first = first_inside();
    EXPECT_NEAR(path.at_s.at(first) - silent_s, number("silence_s"), kLatest);
    expect_one_in(first, static_cast<std::size_t>(number("asks_one_in")), true);
}

TEST_F(WireDocumentFallback, GoesInsideWhenItIsSureAndProbesOneInSoMany) {
    path.server.udp_blocked = true;
    run_for(10.0);
    const std::size_t asked = first_inside();
    std::size_t sure = asked + 1;
    while (sure < path.inside.size() && !(path.inside[sure] && path.inside[sure - 1])) {
        ++sure;
    }
    ASSERT_LT(sure, path.inside.size());
    EXPECT_NEAR(path.at_s[sure] - path.at_s[asked], number("sure_s"), kLatest);
    expect_one_in(sure, static_cast<std::size_t>(number("probes_one_in")), false);
    path.server.udp_blocked = false;
    run_for(3.0);
    const std::size_t later = path.inside.size();
    run_for(1.0);
    EXPECT_EQ(
        std::count(
            path.inside.begin() + static_cast<std::ptrdiff_t>(later), path.inside.end(), true),
        0);
}

}  // namespace
}  // namespace zoned::link
