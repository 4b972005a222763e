// WebSockets of the listener over real sockets: good ones, hostile ones, and who may open them.
#include "server/net/tls_listener.h"
#include "shared/wire/websocket/websocket_frames.h"
#include "shared/wire/websocket/websocket_upgrade.h"

#include <asio/executor_work_guard.hpp>
#include <asio/ip/tcp.hpp>
#include <asio/post.hpp>
#include <asio/read.hpp>
#include <asio/read_until.hpp>
#include <asio/ssl.hpp>
#include <asio/streambuf.hpp>
#include <asio/write.hpp>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <condition_variable>
#include <filesystem>
#include <future>
#include <mutex>
#include <thread>

namespace zoned::net {
namespace {

using namespace std::chrono_literals;
using Bytes = std::vector<std::uint8_t>;

constexpr const char* kOrigin = "https://play.example";

TlsSettings plain_settings() {
    TlsSettings settings;
    settings.bind_address = "127.0.0.1";
    settings.plain = true;
    settings.websocket.emplace();
    settings.websocket->origins = {kOrigin};
    settings.number_after = 1000;
    settings.limits.close_timeout_s = 0.5;
    return settings;
}

/// A listener in a thread of its own, which sends back what it hears.
class WebServer {
  public:
    explicit WebServer(const TlsSettings& settings) {
        TlsCallbacks callbacks;
        callbacks.on_websocket = [this](StreamNumber n, const Address&, bool local, double) {
            record([&] {
                opened.push_back(n);
                locals.push_back(local);
            });
        };
        callbacks.on_frame = [this](StreamNumber n, std::span<const std::uint8_t> frame) {
            listener->send(n, frame);
            record([&] { frames.emplace_back(frame.begin(), frame.end()); });
        };
        callbacks.on_closed = [this](StreamNumber, const std::string& reason) {
            record([&] { closed.push_back(reason); });
        };
        listener = std::make_unique<TlsListener>(io, settings, callbacks);
        port = listener->port();
        listener->start();
        thread = std::thread([this] { io.run(); });
    }

    ~WebServer() {
        asio::post(io, [this] { listener.reset(); });
        work.reset();
        thread.join();
    }

    WebServer(const WebServer&) = delete;
    WebServer& operator=(const WebServer&) = delete;

    std::uint64_t refused(const std::string& reason) {
        std::promise<std::uint64_t> out;
        asio::post(io, [&] {
            const auto& all = listener->stats().websocket_refused;
            const auto it = all.find(reason);
            out.set_value(it == all.end() ? 0 : it->second);
        });
        return out.get_future().get();
    }

    template <class Condition>
    bool wait(Condition condition) {
        std::unique_lock lock(mutex);
        return changed.wait_for(lock, 5s, condition);
    }

    asio::io_context io;
    asio::executor_work_guard<asio::io_context::executor_type> work{io.get_executor()};
    std::unique_ptr<TlsListener> listener;
    std::thread thread;
    std::uint16_t port = 0;
    std::mutex mutex;
    std::condition_variable changed;
    std::vector<StreamNumber> opened;
    std::vector<bool> locals;
    std::vector<std::string> frames;
    std::vector<std::string> closed;

  private:
    template <class F>
    void record(F f) {
        const std::lock_guard lock(mutex);
        f();
        changed.notify_all();
    }
};

/// A client of raw bytes.
class Raw {
  public:
    explicit Raw(std::uint16_t port, int receive_buffer = 0) : socket_(io_) {
        socket_.open(asio::ip::tcp::v4());
        if (receive_buffer > 0) {
            socket_.set_option(asio::socket_base::receive_buffer_size(receive_buffer));
        }
        socket_.connect({asio::ip::make_address("127.0.0.1"), port});
    }

    void send(const std::string& bytes) { asio::write(socket_, asio::buffer(bytes), error); }

    void send_frame(wire::WebSocketOpcode opcode, const std::string& payload) {
        Bytes out;
        wire::write_masked_frame(opcode, Bytes(payload.begin(), payload.end()), 0x1234567, out);
        send({out.begin(), out.end()});
    }

    /// The head of the answer.
    std::string answer() {
        asio::streambuf buffer;
        const std::size_t size = asio::read_until(socket_, buffer, "\r\n\r\n", error);
        std::string text(asio::buffers_begin(buffer.data()), asio::buffers_end(buffer.data()));
        rest_ = text.substr(std::min(size, text.size()));
        return text.substr(0, size);
    }

    bool open(const std::string& more = "") {
        std::string request = wire::upgrade_request("127.0.0.1", "dGhlIHNhbXBsZSBub25jZQ==");
        request.resize(request.size() - 2);
        send(request + more + "\r\n");
        return answer().starts_with("HTTP/1.1 101");
    }

    /// All until the server ends the connection.
    std::string rest() {
        asio::streambuf buffer;
        asio::read(socket_, buffer, error);
        return rest_ +
               std::string(asio::buffers_begin(buffer.data()), asio::buffers_end(buffer.data()));
    }

    std::string receive(std::size_t bytes) {
        while (rest_.size() < bytes && !error) {
            std::array<char, 512> part{};
            rest_.append(part.data(), socket_.read_some(asio::buffer(part), error));
        }
        const std::string out = rest_.substr(0, bytes);
        rest_.erase(0, bytes);
        return out;
    }

    void close() { socket_.close(); }

    asio::error_code error;

  private:
    asio::io_context io_;
    asio::ip::tcp::socket socket_;
    std::string rest_;
};

TEST(WebSockets, CarryFramesBothWays) {
    WebServer server(plain_settings());
    Raw client(server.port);
    ASSERT_TRUE(client.open());
    client.send_frame(wire::WebSocketOpcode::kBinary, "hello");
    EXPECT_EQ(client.receive(7), "\x82\x05hello");
    client.send_frame(wire::WebSocketOpcode::kPing, "are you there");
    EXPECT_EQ(client.receive(15),
              "\x8A\x0D"
              "are you there");
    client.send_frame(wire::WebSocketOpcode::kBinary, std::string(60000, 'l'));
    EXPECT_EQ(client.receive(60004).substr(0, 5), std::string("\x82\x7E\xEA\x60l", 5));
    client.send_frame(wire::WebSocketOpcode::kClose, "\x03\xE8");
    EXPECT_EQ(client.rest(), std::string("\x88\x02\x03\xE8", 4));
    client.close();
    ASSERT_TRUE(server.wait([&] { return server.closed.size() == 1; }));
    EXPECT_EQ(server.closed[0], "");
    EXPECT_EQ(server.opened, std::vector<StreamNumber>{1001});
    EXPECT_TRUE(server.locals.at(0));
}

TEST(WebSockets, TakeAMessageThatCameWithTheRequest) {
    WebServer server(plain_settings());
    Raw client(server.port);
    Bytes frame;
    wire::write_masked_frame(
        wire::WebSocketOpcode::kBinary, Bytes{'e', 'a', 'r', 'l', 'y'}, 7, frame);
    client.send(wire::upgrade_request("127.0.0.1", "dGhlIHNhbXBsZSBub25jZQ==") +
                std::string(frame.begin(), frame.end()));
    EXPECT_THAT(client.answer(), ::testing::StartsWith("HTTP/1.1 101"));
    EXPECT_EQ(client.receive(7),
              "\x82\x05"
              "early");
}

TEST(WebSockets, OpenForPagesOfListedSitesAlone) {
    WebServer server(plain_settings());
    for (const char* foreign : {"https://evil.example",
                                "http://play.example",
                                "null",
                                "https://play.example.evil",
                                "https://play.example:444"}) {
        Raw client(server.port);
        EXPECT_FALSE(client.open(std::string("Origin: ") + foreign + "\r\n")) << foreign;
    }
    EXPECT_EQ(server.refused("origin"), 5U);
    EXPECT_TRUE(server.opened.empty());
    Raw good(server.port);
    EXPECT_TRUE(good.open(std::string("Origin: ") + kOrigin + "\r\n"));
    asio::post(server.io, [&] { server.listener->set_origins({"http://other"}); });
    EXPECT_EQ(server.refused("origin"), 5U);  // and the post has run
    Raw late(server.port);
    EXPECT_FALSE(late.open(std::string("Origin: ") + kOrigin + "\r\n"));
}

TEST(WebSockets, ThatAProxyPassesOnAreNotLocal) {
    WebServer server(plain_settings());
    Raw client(server.port);
    EXPECT_TRUE(client.open("X-Forwarded-For: 203.0.113.7\r\n"));
    ASSERT_TRUE(server.wait([&] { return server.opened.size() == 1; }));
    EXPECT_FALSE(server.locals.at(0));
}

TEST(WebSockets, BytesThatAreNoUpgradeAreAnsweredAndCounted) {
    WebServer server(plain_settings());
    const auto answer = [&](const std::string& bytes) {
        Raw client(server.port);
        client.send(bytes);
        return client.answer();
    };
    EXPECT_THAT(answer("GET / HTTP/1.1\r\nHost: a\r\n\r\n"), ::testing::StartsWith("HTTP/1.1 426"));
    EXPECT_EQ(server.refused("upgrade_missing"), 1U);
    EXPECT_THAT(answer("GET /x HTTP/1.1\r\n\r\n"), ::testing::StartsWith("HTTP/1.1 404"));
    EXPECT_EQ(server.refused("upgrade_path"), 1U);
    // A frame of the other port, and TLS.
    EXPECT_THAT(answer(std::string("\x10\0\0\0hello", 9)), ::testing::StartsWith("HTTP/1.1 405"));
    EXPECT_THAT(answer("\x16\x03\x01\x02"), ::testing::StartsWith("HTTP/1.1 405"));
    EXPECT_EQ(server.refused("upgrade_method"), 2U);
    EXPECT_THAT(answer("GET / HTTP/1.1\r\n" + std::string(9000, 'a')),
                ::testing::StartsWith("HTTP/1.1 431"));
    EXPECT_EQ(server.refused("upgrade_long"), 1U);
    EXPECT_TRUE(server.opened.empty());
    EXPECT_TRUE(server.closed.empty());
}

TEST(WebSockets, HandshakesThatAreTooSlowEnd) {
    TlsSettings settings = plain_settings();
    settings.limits.handshake_timeout_s = 0.1;
    WebServer server(settings);
    Raw silent(server.port);
    Raw slow(server.port);
    slow.send("GET / HTTP/1.1\r\nHost: a\r\n");
    EXPECT_EQ(silent.rest(), "");
    EXPECT_EQ(slow.rest(), "");
    std::promise<std::uint64_t> timeouts;
    asio::post(server.io, [&] { timeouts.set_value(server.listener->stats().handshake_timeout); });
    EXPECT_EQ(timeouts.get_future().get(), 2U);
}

/// The Close frame that answers bytes on an open WebSocket: its code; 0: there is none.
unsigned close_code(WebServer& server, const std::string& bytes) {
    Raw client(server.port);
    EXPECT_TRUE(client.open());
    client.send(bytes);
    const std::string rest = client.rest();
    const std::size_t at = rest.rfind('\x88');
    return at == std::string::npos || at + 3 >= rest.size()
               ? 0
               : static_cast<unsigned char>(rest[at + 2]) * 256U +
                     static_cast<unsigned char>(rest[at + 3]);
}

TEST(WebSockets, HostileFramesEndTheStreamWithACodeAndACount) {
    WebServer server(plain_settings());
    EXPECT_EQ(close_code(server,
                         "\x82\x05"
                         "plain"),
              1002U);
    EXPECT_EQ(close_code(server,
                         "\xF2\x80"
                         "mask"),
              1002U);
    EXPECT_EQ(close_code(server, std::string("\x00\x80mask", 6)), 1002U);
    EXPECT_EQ(close_code(server, "\x81\x81maskA"), 1003U);
    EXPECT_EQ(server.refused("framing"), 4U);
    EXPECT_EQ(close_code(server, "\x82\xFF\x7F\xFF\xFF\xFF\xFF\xFF\xFF\xFFmask"), 1009U);
    EXPECT_EQ(close_code(server, std::string("\x82\xFF\0\0\0\0\0\1\0\1mask", 14)), 1009U);
    EXPECT_EQ(server.refused("message_oversize"), 2U);
    std::string pings;
    for (int i = 0; i < 40; ++i) {
        pings += std::string("\x89\x80mask", 6);
    }
    EXPECT_EQ(close_code(server, pings), 1008U);
    EXPECT_EQ(server.refused("control_flood"), 1U);
    // The server goes on.
    Raw good(server.port);
    ASSERT_TRUE(good.open());
    good.send_frame(wire::WebSocketOpcode::kBinary, "still");
    EXPECT_EQ(good.receive(7), "\x82\x05still");
    EXPECT_EQ(server.frames, std::vector<std::string>{"still"});
}

TEST(WebSockets, LeaveLittleToTheKernelsQueue) {
    WebServer server(plain_settings());
    Raw client(server.port, 4096);
    ASSERT_TRUE(client.open());
    ASSERT_TRUE(server.wait([&] { return server.opened.size() == 1; }));
    const auto backlog = [&] {
        std::promise<std::size_t> out;
        asio::post(server.io, [&] { out.set_value(server.listener->backlog(1001)); });
        return out.get_future().get();
    };
    // The client reads nothing. What neither it nor the kernel holds is counted.
    std::size_t sent = 0;
    bool full = false;
    while (!full && sent < (4U << 20U)) {
        asio::post(server.io,
                   [&] { server.listener->send(1001, std::vector<std::uint8_t>(1000, 7)); });
        sent += 1000;
        full = true;
        for (int i = 0; i < 50 && full; ++i) {
            std::this_thread::sleep_for(100us);
            full = backlog() > 0;
        }
    }
    EXPECT_TRUE(full);
    EXPECT_LT(sent, 40000U);
}

TEST(WebSockets, WithoutTlsListenOnLoopbackAlone) {
    asio::io_context io;
    TlsSettings settings = plain_settings();
    settings.bind_address = "0.0.0.0";
    EXPECT_THROW(TlsListener(io, settings, {}), std::runtime_error);
    settings.bind_address = "127.0.0.1";
    settings.websocket.reset();
    EXPECT_THROW(TlsListener(io, settings, {}), std::runtime_error);
}

TEST(WebSockets, GoByTlsElsewhere) {
    std::string folder = ::testing::TempDir() + "zoned-wss-XXXXXX";
    ASSERT_NE(mkdtemp(folder.data()), nullptr);
    TlsSettings settings = plain_settings();
    settings.plain = false;
    settings.bind_address = "::";
    settings.certificate.state_dir = folder;
    {
        WebServer server(settings);
        asio::io_context io;
        asio::ssl::context context(asio::ssl::context::tls_client);
        asio::ssl::stream<asio::ip::tcp::socket> stream(io, context);
        stream.next_layer().connect({asio::ip::make_address("127.0.0.1"), server.port});
        stream.handshake(asio::ssl::stream_base::client);
        asio::write(stream, asio::buffer(wire::upgrade_request("h", "dGhlIHNhbXBsZSBub25jZQ==")));
        asio::streambuf buffer;
        asio::read_until(stream, buffer, "\r\n\r\n");
        const std::string text(asio::buffers_begin(buffer.data()),
                               asio::buffers_end(buffer.data()));
        EXPECT_THAT(text, ::testing::StartsWith("HTTP/1.1 101"));
        Raw plain(server.port);
        plain.send(wire::upgrade_request("h", "dGhlIHNhbXBsZSBub25jZQ=="));
        EXPECT_THAT(plain.rest(), ::testing::Not(::testing::StartsWith("HTTP/1.1 101")));
    }
    std::filesystem::remove_all(folder);
}

}  // namespace
}  // namespace zoned::net
