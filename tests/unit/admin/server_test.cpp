// The admin server over real sockets, against bytes that are meant to hurt it.
#include "server/admin/admin_server.h"
#include "server/admin/spectator_service.h"
#include "tests/unit/admin/raw_socket.h"

#include <gtest/gtest.h>
#include <sys/resource.h>

#include <chrono>
#include <future>
#include <memory>
#include <random>
#include <stdexcept>
#include <system_error>
#include <thread>

namespace zoned::admin {
namespace {

using testing_admin::RawSocket;
using testing_admin::send_raw;
using testing_admin::status_of;

const std::string kToken(64, 'a');
const std::string kBearer = "Authorization: Bearer " + kToken + "\r\n";

class Served : public ::testing::Test {
  protected:
    void serve(AdminSettings settings = {}) {
        settings.token = kToken;
        std::vector<AdminRoute> routes;
        const auto add = [&](const char* method, const char* path, auto handle) {
            routes.push_back({method, path, true, handle});
        };
        add("GET", "/ok", [](const AdminCall&, const AdminReply& reply) {
            AdminResponse response;
            response.body = "fine";
            reply(response);
        });
        add("GET", "/large", [](const AdminCall&, const AdminReply& reply) {
            AdminResponse response;
            response.body.assign(32U << 20U, 'x');
            reply(response);
        });
        add("GET", "/silent", [this](const AdminCall&, const AdminReply& reply) { kept_ = reply; });
        add("GET", "/later", [this](const AdminCall&, const AdminReply& reply) {
            helper_ = std::thread([reply] {
                AdminResponse response;
                response.body = "from another thread";
                reply(response);
                reply(response);  // the second one is dropped
            });
        });
        add("GET", "/throws", [](const AdminCall&, const AdminReply&) {
            throw std::runtime_error("a fault of a route");
        });
        add("POST", "/echo", [](const AdminCall& call, const AdminReply& reply) {
            AdminResponse response;
            response.body = call.request.body;
            reply(response);
        });
        server_ = std::make_unique<AdminServer>(settings, std::move(routes));
        server_->start();
    }

    void TearDown() override {
        if (helper_.joinable()) {
            helper_.join();
        }
    }

    [[nodiscard]] std::uint16_t port() const { return server_->port(); }

    std::string get(const std::string& target, const std::string& more = "") const {
        return testing_admin::get(port(), target, more);
    }

    std::string post(const std::string& body, std::size_t length) const {
        return send_raw(port(),
                        "POST /echo HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n"
                        "Content-Type: application/json\r\nContent-Length: " +
                            std::to_string(length) + "\r\n\r\n" + body);
    }

    std::uint64_t refused(const std::string& reason) const {
        std::promise<std::uint64_t> count;
        server_->post([&] {
            const AdminCounters& counters = server_->router().refused();
            const auto it = counters.find(reason);
            count.set_value(it == counters.end() ? 0 : it->second);
        });
        return count.get_future().get();
    }

    void expect_alive() const { EXPECT_EQ(status_of(get("/ok")), 200); }

    AdminReply kept_;
    std::thread helper_;
    std::unique_ptr<AdminServer> server_;
};

TEST_F(Served, AnswersAndKeepsTheConnectionOpen) {
    serve();
    const RawSocket socket(port());
    for (int i = 0; i < 3; ++i) {
        ASSERT_TRUE(socket.send("GET /ok HTTP/1.1\r\nHost: localhost\r\n\r\n"));
        const std::string answer = socket.receive_until("fine");
        EXPECT_EQ(status_of(answer), 200) << answer;
        EXPECT_NE(answer.find("Cache-Control: no-store"), std::string::npos);
        EXPECT_NE(answer.find("X-Content-Type-Options: nosniff"), std::string::npos);
    }
}

TEST_F(Served, TakesPipelinedRequestsInOrder) {
    serve();
    const std::string one = "GET /ok HTTP/1.1\r\nHost: localhost\r\n\r\n";
    const std::string answers = send_raw(
        port(), one + one + "GET /none HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n\r\n");
    EXPECT_EQ(status_of(answers), 200);
    EXPECT_NE(answers.find("HTTP/1.1 404 Not Found"), std::string::npos) << answers;
}

TEST_F(Served, TakesAReplyOfAnotherThreadOnce) {
    serve();
    EXPECT_NE(get("/later").find("from another thread"), std::string::npos);
    expect_alive();
}

TEST_F(Served, SurvivesARouteThatThrows) {
    serve();
    AdminSettings settings;
    {
        const RawSocket socket(port());
        socket.send("GET /throws HTTP/1.1\r\nHost: localhost\r\n\r\n");
        expect_alive();
    }
    EXPECT_EQ(refused("exception"), 1U);
}

TEST_F(Served, RefusesWhatIsNoHttp) {
    serve();
    for (const char* bytes : {"\r\n\r\n\r\nx\r\n\r\n",
                              "GET\r\n\r\n",
                              "GET /ok\r\n\r\n",
                              "GET /ok HTTP/9.9\r\n\r\n",
                              "GET /ok HTTP/1.1\r\nHost localhost\r\n\r\n",
                              "GET /ok HTTP/1.1\r\nHost: a\r\nContent-Length: x\r\n\r\n",
                              "GET /ok HTTP/1.1\r\nContent-Length: 1\r\nContent-Length: 2\r\n\r\n",
                              "POST /echo HTTP/1.1\r\nTransfer-Encoding: chunked\r\n\r\nzz\r\n\r\n",
                              "\x16\x03\x01\x02\x00\x01\x00\x01\xfc\x03\x03 hello\r\n\r\n"}) {
        const std::string answer = send_raw(port(), bytes);
        EXPECT_EQ(status_of(answer), 400) << bytes << "\n" << answer;
        EXPECT_NE(answer.find("application/problem+json"), std::string::npos);
    }
    EXPECT_EQ(refused("malformed"), 9U);
    expect_alive();
}

TEST_F(Served, SurvivesRandomBytes) {
    serve();
    std::mt19937 random(7);
    const std::string front = "POST /echo HTTP/1.1\r\nHost: localhost\r\n";
    for (int i = 0; i < 300; ++i) {
        std::string bytes = i % 2 == 0 ? front : "";
        for (int n = 0; n < 200; ++n) {
            bytes += static_cast<char>(random() & 0xFFU);
        }
        const RawSocket socket(port());
        socket.send(bytes + "\r\n\r\n");
    }
    expect_alive();
}

TEST_F(Served, RefusesLongHeadersAndBodies) {
    serve();
    EXPECT_EQ(status_of(get("/ok", "X: " + std::string(9000, 'x') + "\r\n")), 431);
    EXPECT_EQ(refused("header_long"), 1U);
    EXPECT_EQ(status_of(get("/" + std::string(2000, 'a'))), 414);
    EXPECT_EQ(status_of(post(std::string(65536, 'b'), 65536)), 200);
    EXPECT_EQ(status_of(post(std::string(65537, 'b'), 65537)), 413);
    EXPECT_EQ(status_of(post("", 1ULL << 40U)), 413);
    EXPECT_EQ(refused("body_long"), 2U);
    // Ten megabytes are read and thrown away up to a limit; the connection may break while sending.
    const std::string answer = post(std::string(10U << 20U, 'b'), 10U << 20U);
    EXPECT_TRUE(answer.empty() || status_of(answer) == 413) << answer.substr(0, 100);
    expect_alive();
}

TEST_F(Served, RefusesAChunkedBodyThatGrowsBeyondTheLimit) {
    serve();
    std::string request =
        "POST /echo HTTP/1.1\r\nHost: localhost\r\nContent-Type: application/json\r\n"
        "Transfer-Encoding: chunked\r\n\r\n";
    for (int i = 0; i < 20; ++i) {
        request += "1000\r\n" + std::string(4096, 'c') + "\r\n";
    }
    EXPECT_EQ(status_of(send_raw(port(), request + "0\r\n\r\n")), 413);
    expect_alive();
}

TEST_F(Served, ClosesConnectionsThatSendNothingOrSlowly) {
    AdminSettings settings;
    settings.request_timeout_s = 0.2;
    serve(settings);
    const RawSocket silent(port());
    const RawSocket slow(port());
    slow.send("GET /ok HTTP/1.1\r\nHost: loc");
    EXPECT_TRUE(silent.closed());
    EXPECT_TRUE(slow.closed());
    // Beast closes the socket first, and the reader that counts runs afterwards.
    for (int i = 0; i < 100'000 && refused("timeout") < 2; ++i) {
    }
    EXPECT_EQ(refused("timeout"), 2U);
    // A request that the machine holds up for as long is late as well.
    int status = 0;
    for (int i = 0; i < 20 && status != 200; ++i) {
        status = status_of(get("/ok"));
    }
    EXPECT_EQ(status, 200);
}

TEST_F(Served, DropsAReaderThatDoesNotRead) {
    AdminSettings settings;
    settings.write_timeout_s = 0.2;
    serve(settings);
    const RawSocket slow(port(), 4096);
    slow.send("GET /large HTTP/1.1\r\nHost: localhost\r\n\r\n");
    const auto patience = std::chrono::steady_clock::now() + std::chrono::seconds(10);
    while (refused("slow_reader") == 0 && std::chrono::steady_clock::now() < patience) {
    }
    EXPECT_EQ(refused("slow_reader"), 1U);
    EXPECT_LT(slow.receive_all().size(), 32U << 20U);
    expect_alive();
}

TEST_F(Served, SaysWhenTheProcessDoesNotAnswer) {
    AdminSettings settings;
    settings.answer_timeout_s = 0.1;
    serve(settings);
    EXPECT_EQ(status_of(get("/silent")), 504);
    kept_(AdminResponse{});  // too late: dropped
    expect_alive();
}

TEST_F(Served, LimitsTheRequestsOfAConnection) {
    AdminSettings settings;
    settings.requests_per_s = 5.0;
    serve(settings);
    std::string many;
    for (int i = 0; i < 30; ++i) {
        many += "GET /ok HTTP/1.1\r\nHost: localhost\r\n\r\n";
    }
    const std::string answers = send_raw(port(), many);
    EXPECT_NE(answers.find("HTTP/1.1 429 Too Many Requests"), std::string::npos);
    EXPECT_EQ(refused("flood"), 1U);
    expect_alive();
}

TEST_F(Served, AnswersWhileTenThousandSocketsAreOpen) {
    serve();
    rlimit limit{};
    ASSERT_EQ(::getrlimit(RLIMIT_NOFILE, &limit), 0);
    limit.rlim_cur = limit.rlim_max;
    ASSERT_EQ(::setrlimit(RLIMIT_NOFILE, &limit), 0);
    const std::size_t wanted = std::min<std::size_t>(10000, limit.rlim_cur - 1000);
    std::vector<RawSocket> sockets;
    for (std::size_t i = 0; i < wanted; ++i) {
        sockets.emplace_back(port());
        ASSERT_TRUE(sockets.back().open()) << i;
        if (i % 1000 == 0) {
            expect_alive();
        }
    }
    expect_alive();
    EXPECT_GE(refused("evicted"), wanted - AdminSettings{}.max_connections);
    std::promise<std::size_t> open;
    server_->post([&] { open.set_value(server_->stats().connections); });
    EXPECT_LE(open.get_future().get(), AdminSettings{}.max_connections);
}

TEST_F(Served, RefusesNewcomersWhileEveryConnectionIsBusy) {
    AdminSettings settings;
    settings.max_connections = 4;
    settings.answer_timeout_s = 2.0;
    serve(settings);
    std::vector<RawSocket> busy;
    for (int i = 0; i < 4; ++i) {
        busy.emplace_back(port());
        busy.back().send("GET /silent HTTP/1.1\r\nHost: localhost\r\n\r\n");
    }
    std::string answer;
    for (int i = 0; i < 100 && refused("connections") == 0; ++i) {
        answer = get("/ok");
    }
    EXPECT_EQ(status_of(answer), 503) << answer;
    EXPECT_NE(answer.find("in use"), std::string::npos);
    // Once they have their answers they wait for requests, and give way.
    for (const RawSocket& socket : busy) {
        EXPECT_EQ(status_of(socket.receive_until("\r\n\r\n")), 504);
    }
    expect_alive();
}

/// A world in which every entity of many moves all the time.
class Spectated : public Served {
  protected:
    void SetUp() override {
        AdminSettings settings;
        settings.token = kToken;
        SpectatorSource source;
        source.rate_hz = 200.0;
        source.scene = [] {
            return "{\"world\": \"test\"}";
        };
        source.sample = [this](const std::shared_ptr<SpectatorSample>& into,
                               const std::function<void()>& taken) {
            fill(*into);
            taken();
            return true;
        };
        server_ = std::make_unique<AdminServer>(settings, std::vector<AdminRoute>{}, source);
        server_->start();
    }

    void TearDown() override { server_.reset(); }  // its thread fills samples to the end

    void fill(SpectatorSample& sample) {
        sample.tick = ++samples_;
        sample.zones.resize(1);
        SpectatorZone& zone = sample.zones[0];
        zone.id.clear();
        for (std::uint32_t i = 1; i <= kEntities; ++i) {
            zone.id.emplace_back(i);
        }
        zone.type.assign(kEntities, 0);
        zone.flags.assign(kEntities, 0);
        zone.client.assign(kEntities, {});
        zone.position.assign(kEntities, Vec3(static_cast<float>(samples_), 0.0F, 0.0F));
        zone.orientation.assign(kEntities, Quat::Identity());
        zone.velocity.assign(kEntities, Vec3::Zero());
        layers_asked_ = sample.layers;
    }

    static std::string upgrade(const std::string& token, const std::string& more = "") {
        return "GET /api/v1/spectate HTTP/1.1\r\nHost: 127.0.0.1\r\nConnection: Upgrade\r\n"
               "Upgrade: websocket\r\nSec-WebSocket-Version: 13\r\n"
               "Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n"
               "Sec-WebSocket-Protocol: zoned, " +
               token + "\r\n" + more + "\r\n";
    }

    std::size_t viewers() const {
        std::promise<std::size_t> count;
        server_->post([&] { count.set_value(server_->stats().viewers); });
        return count.get_future().get();
    }

    static constexpr std::uint32_t kEntities = 20000;
    std::int64_t samples_ = 0;
    std::atomic<std::uint32_t> layers_asked_{0};
};

TEST_F(Spectated, ShowsTheWorldToWhoeverHasTheToken) {
    const RawSocket viewer(port());
    viewer.send(upgrade(kToken));
    const std::string head = viewer.receive_until("\r\n\r\n");
    EXPECT_EQ(status_of(head), 101) << head;
    EXPECT_NE(viewer.receive_until("}").find("\"world\": \"test\""), std::string::npos);
    EXPECT_EQ(viewers(), 1U);
    // A binary frame (0x82) with a length of 64 bits: 16 + 44 x 20,000 bytes (RFC 6455, 5.2).
    const std::string frame = viewer.receive_until(std::string("\x01\0\0\0", 4));
    EXPECT_EQ(frame.substr(0, 2), "\x82\x7F");
    EXPECT_EQ(static_cast<unsigned char>(frame[9]), (16U + 44U * kEntities) & 0xFFU);
}

TEST_F(Spectated, RefusesForeignPagesAndWrongTokens) {
    const RawSocket wrong(port());
    wrong.send(upgrade("x"));
    EXPECT_EQ(status_of(wrong.receive_until("\r\n\r\n")), 401);
    for (const char* origin : {"http://evil.example", "null", "http://127.0.0.1:1"}) {
        const RawSocket viewer(port());
        viewer.send(upgrade(kToken, std::string("Origin: ") + origin + "\r\n"));
        EXPECT_EQ(status_of(viewer.receive_until("\r\n\r\n")), 403) << origin;
    }
    EXPECT_EQ(viewers(), 0U);
}

TEST_F(Spectated, SkipsWhatASlowViewerDoesNotTake) {
    const RawSocket slow(port(), 4096);
    slow.send(upgrade(kToken));
    const auto patience = std::chrono::steady_clock::now() + std::chrono::seconds(10);
    while (refused("slow_viewer") == 0 && std::chrono::steady_clock::now() < patience) {
    }
    EXPECT_EQ(refused("slow_viewer"), 1U);
    EXPECT_EQ(viewers(), 1U);
}

/// A masked binary frame (RFC 6455, 5.2); the mask is zero.
std::string binary_frame(const std::string& bytes) {
    return "\x82" + std::string(1, static_cast<char>(0x80U | bytes.size())) + std::string(4, '\0') +
           bytes;
}

TEST_F(Spectated, SamplesTheLayersThatViewersAskFor) {
    const RawSocket viewer(port());
    viewer.send(upgrade(kToken));
    viewer.receive_until("\r\n\r\n");
    viewer.send(binary_frame(std::string("\x05\0\0\0", 4) + std::string(12, '\0')));
    const auto patience = std::chrono::steady_clock::now() + std::chrono::seconds(10);
    while (layers_asked_ != 5U && std::chrono::steady_clock::now() < patience) {
    }
    EXPECT_EQ(layers_asked_, 5U);
    // A wish of another length, and an eye that is nowhere (NaN), change nothing.
    viewer.send(binary_frame("short"));
    viewer.send(binary_frame(std::string("\x01\0\0\0\0\0\xC0\x7F", 8) + std::string(8, '\0')));
    while (refused("bad_wish") != 2 && std::chrono::steady_clock::now() < patience) {
    }
    EXPECT_EQ(refused("bad_wish"), 2U);
    EXPECT_EQ(layers_asked_, 5U);
    EXPECT_EQ(viewers(), 1U);
}

TEST_F(Spectated, ClosesAViewerThatTalks) {
    const RawSocket viewer(port());
    viewer.send(upgrade(kToken));
    viewer.receive_until("\r\n\r\n");
    // A masked text frame of 65,535 bytes; then bytes that are no frame at all.
    viewer.send("\x81\xFE\xFF\xFF" + std::string(4, '\x01') + std::string(65535, 'x'));
    const auto patience = std::chrono::steady_clock::now() + std::chrono::seconds(10);
    while (viewers() != 0 && std::chrono::steady_clock::now() < patience) {
    }
    EXPECT_EQ(viewers(), 0U);
}

TEST_F(Spectated, HasRoomForSoManyViewersAndForgetsThoseThatLeave) {
    {
        std::vector<RawSocket> all;
        for (std::size_t i = 0; i < kMostViewers; ++i) {
            all.emplace_back(port());
            all.back().send(upgrade(kToken));
            EXPECT_EQ(status_of(all.back().receive_until("\r\n\r\n")), 101);
        }
        const RawSocket late(port());
        late.send(upgrade(kToken));
        EXPECT_EQ(status_of(late.receive_until("\r\n\r\n")), 503);
    }
    const auto patience = std::chrono::steady_clock::now() + std::chrono::seconds(10);
    while (viewers() != 0 && std::chrono::steady_clock::now() < patience) {
    }
    EXPECT_EQ(viewers(), 0U);
}

TEST(AdminServer, BindsLoopbackAddressesOnly) {
    for (const char* address : {"0.0.0.0", "::", "192.0.2.1", "localhost", ""}) {
        AdminSettings settings;
        settings.address = address;
        EXPECT_THROW(AdminServer(settings, {}), std::invalid_argument) << address;
    }
}

TEST(AdminServer, SaysWhichPortIsTaken) {
    const AdminServer first(AdminSettings{}, {});
    AdminSettings settings;
    settings.port = first.port();
    try {
        const AdminServer second(settings, {});
        FAIL() << "both listen on one port";
    } catch (const std::system_error& error) {
        EXPECT_NE(std::string(error.what()).find(std::to_string(first.port())), std::string::npos);
        EXPECT_NE(std::string(error.what()).find("network.admin_port"), std::string::npos);
    }
}

}  // namespace
}  // namespace zoned::admin
