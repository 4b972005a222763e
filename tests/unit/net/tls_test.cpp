#include "server/net/tls_listener.h"
#include "tests/unit/net/tls_client.h"

#include <asio/executor_work_guard.hpp>
#include <asio/post.hpp>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <filesystem>
#include <fstream>
#include <map>
#include <mutex>
#include <thread>

namespace zoned::net {
namespace {

using namespace std::chrono_literals;

/// A folder that goes with the test.
class StateDir {
  public:
    StateDir() {
        std::string pattern = testing::TempDir() + "zoned-net-XXXXXX";
        path = mkdtemp(pattern.data());
    }

    ~StateDir() { std::filesystem::remove_all(path); }

    StateDir(const StateDir&) = delete;
    StateDir& operator=(const StateDir&) = delete;

    std::string path;
};

TlsSettings settings_in(const StateDir& dir, const std::string& address = "127.0.0.1") {
    TlsSettings settings;
    settings.bind_address = address;
    settings.certificate.state_dir = dir.path;
    return settings;
}

/// A listener in a thread of its own, and its reports.
class Server {
  public:
    explicit Server(const TlsSettings& settings) {
        TlsCallbacks callbacks;
        callbacks.on_open =
            [this](StreamNumber n, const Address&, bool loopback, double client_spent_s) {
                record([&] {
                    opened.push_back(n);
                    spent_s.push_back(client_spent_s);
                    all_loopback = all_loopback && loopback;
                });
            };
        callbacks.on_frame = [this](StreamNumber n, std::span<const std::uint8_t> frame) {
            const std::string text(frame.begin(), frame.end());
            record([&] { frames.push_back(text); });
            if (text == "echo") {
                listener->send(n, frame);
            } else if (text == "close") {
                const std::string last = "last words";
                for (int i = 0; i < 100; ++i) {
                    listener->send(n, {reinterpret_cast<const std::uint8_t*>(last.data()), 10});
                }
                listener->close(n);
            } else if (text == "tail") {
                const auto tail = std::make_shared<const std::vector<std::uint8_t>>(3'000'000, 't');
                const auto send = [&](const std::string& part, const SharedBytes& end) {
                    listener->send(
                        n, {reinterpret_cast<const std::uint8_t*>(part.data()), part.size()}, end);
                };
                send("head:", tail);
                send("after it", nullptr);
                send("head:", tail);
                backlog = listener->backlog(n);
            } else if (text == "flood") {
                const std::vector<std::uint8_t> big(60'000, 1);
                for (int i = 0; i < 1000; ++i) {
                    listener->send(n, big);
                }
            }
        };
        callbacks.on_closed = [this](StreamNumber, const std::string& reason) {
            record([&] { closed.push_back(reason); });
        };
        listener = std::make_unique<TlsListener>(io, settings, callbacks);
        port = listener->port();
        fingerprint = listener->fingerprint();
        listener->start();
        thread = std::thread([this] { io.run(); });
    }

    ~Server() { stop(); }

    Server(const Server&) = delete;
    Server& operator=(const Server&) = delete;

    void stop() {
        if (thread.joinable()) {
            asio::post(io, [this] { listener.reset(); });
            work.reset();
            thread.join();
        }
    }

    /// Statistics once the listener's thread has stopped writing them.
    TlsStats stats() {
        TlsStats out;
        on_thread([&] { out = listener->stats(); });
        return out;
    }

    std::size_t connections() {
        std::size_t out = 0;
        on_thread([&] { out = listener->connections(); });
        return out;
    }

    template <class Condition>
    bool wait(Condition condition) {
        std::unique_lock lock(mutex);
        return changed.wait_for(lock, 5s, condition);
    }

    std::string first_reason() {
        const std::lock_guard lock(mutex);
        return closed.at(0);
    }

    asio::io_context io;
    asio::executor_work_guard<asio::io_context::executor_type> work{io.get_executor()};
    std::unique_ptr<TlsListener> listener;
    std::thread thread;
    std::uint16_t port = 0;
    std::string fingerprint;
    std::size_t backlog = 0;
    std::mutex mutex;
    std::condition_variable changed;
    std::vector<StreamNumber> opened;
    std::vector<double> spent_s;
    bool all_loopback = true;
    std::vector<std::string> frames;
    std::vector<std::string> closed;

  private:
    template <class F>
    void record(F f) {
        const std::lock_guard lock(mutex);
        f();
        changed.notify_all();
    }

    template <class F>
    void on_thread(F f) {
        std::unique_lock lock(mutex);
        bool done = false;
        asio::post(io, [&] {
            const std::lock_guard inner(mutex);
            f();
            done = true;
            changed.notify_all();
        });
        ASSERT_TRUE(changed.wait_for(lock, 5s, [&] { return done; }));
    }
};

TEST(TlsListener, CarriesFramesOfAnySizeHoweverTheyAreCut) {
    const StateDir dir;
    Server server(settings_in(dir));
    TlsClient client;
    ASSERT_TRUE(client.connect(server.port));
    std::string stream;
    std::vector<std::string> sent;
    for (const std::size_t size :
         {std::size_t{0}, std::size_t{1}, std::size_t{65536}, std::size_t{3}, std::size_t{5000}}) {
        sent.emplace_back(size, static_cast<char>('a' + sent.size()));
        stream += TlsClient::prefix(size) + sent.back();
    }
    for (std::size_t at = 0; at < stream.size();) {
        const std::size_t piece = at < 20 ? 1 : 4097;
        client.send_raw(stream.substr(at, piece));
        at += piece;
    }
    ASSERT_TRUE(server.wait([&] { return server.frames.size() == sent.size(); }));
    EXPECT_EQ(server.frames, sent);
    client.send("echo");
    EXPECT_EQ(client.receive(), "echo");
    client.close();
    ASSERT_TRUE(server.wait([&] { return server.closed.size() == 1; }));
    EXPECT_EQ(server.first_reason(), "");
}

TEST(TlsListener, EndsAStreamThatAnnouncesAFrameTooLong) {
    const StateDir dir;
    Server server(settings_in(dir));
    TlsClient client;
    ASSERT_TRUE(client.connect(server.port));
    client.send_raw(TlsClient::prefix(65537));
    EXPECT_EQ(client.receive(), "");
    EXPECT_TRUE(client.error);
    ASSERT_TRUE(server.wait([&] { return server.closed.size() == 1; }));
    EXPECT_THAT(server.first_reason(), testing::HasSubstr("65537 bytes was announced"));
    EXPECT_EQ(server.stats().frame_oversize, 1U);
    std::map<std::string, std::uint64_t> refused{{"frame_oversize", 4}, {"silence", 2}};
    add_refusals(server.stats(), refused);
    EXPECT_EQ(refused,
              (std::map<std::string, std::uint64_t>{{"frame_oversize", 5}, {"silence", 2}}));
    EXPECT_EQ(server.connections(), 0U);
}

TEST(TlsListener, SendsAllThatIsQueuedBeforeItClosesEvenWhileThePeerSends) {
    const StateDir dir;
    Server server(settings_in(dir));
    for (int round = 0; round < 10; ++round) {
        TlsClient client;
        ASSERT_TRUE(client.connect(server.port));
        client.send("close");
        for (int i = 0; i < 50; ++i) {
            client.send("still talking");
        }
        for (int i = 0; i < 100; ++i) {
            ASSERT_EQ(client.receive(), "last words") << i << " " << client.error.message();
        }
        EXPECT_EQ(client.receive(), "");
        EXPECT_EQ(client.error, asio::error::eof);  // close_notify, not a cut
        client.close();
        client.vanish();
    }
    ASSERT_TRUE(server.wait([&] { return server.closed.size() == 10; }));
    EXPECT_EQ(server.stats().close_timeout, 0U);
}

TEST(TlsListener, DropsAClientThatDoesNotReadAndCountsIt) {
    const StateDir dir;
    Server server(settings_in(dir));
    TlsClient client;
    ASSERT_TRUE(client.connect(server.port));
    client.send("flood");
    ASSERT_TRUE(server.wait([&] { return server.closed.size() == 1; }));
    EXPECT_THAT(server.first_reason(), testing::HasSubstr("too slow"));
    EXPECT_EQ(server.stats().queue_overflow, 1U);
}

TEST(TlsListener, SendsSharedTailsBeyondTheQueueLimitInOrder) {
    const StateDir dir;
    Server server(settings_in(dir));
    TlsClient client;
    ASSERT_TRUE(client.connect(server.port));
    client.send("tail");
    // Three times as much as may wait, and a frame behind it.
    const std::string large = client.receive();
    ASSERT_EQ(large.size(), 5U + 3'000'000U) << client.error;
    EXPECT_EQ(large.substr(0, 5), "head:");
    EXPECT_EQ(std::count(large.begin() + 5, large.end(), 't'), 3'000'000);
    EXPECT_EQ(client.receive(), "after it");
    EXPECT_EQ(client.receive().size(), 5U + 3'000'000U);
    EXPECT_EQ(server.stats().queue_overflow, 0U);
    EXPECT_EQ(server.backlog, 2 * (4U + 5U + 3'000'000U) + 4U + 8U);
}

TEST(TlsListener, NoticesAPeerThatVanishes) {
    const StateDir dir;
    Server server(settings_in(dir));
    TlsClient client;
    ASSERT_TRUE(client.connect(server.port));
    ASSERT_TRUE(server.wait([&] { return server.opened.size() == 1; }));
    client.vanish();
    ASSERT_TRUE(server.wait([&] { return server.closed.size() == 1; }));
    EXPECT_THAT(server.first_reason(), testing::HasSubstr("lost"));
}

TEST(TlsListener, SpeaksTls13OnlyAndSurvivesNoise) {
    const StateDir dir;
    Server server(settings_in(dir));
    TlsClient old;
    old.allow_at_most(TLS1_2_VERSION);
    EXPECT_FALSE(old.connect(server.port));
    asio::io_context io;
    asio::ip::tcp::socket noise(io);
    noise.connect({asio::ip::make_address("127.0.0.1"), server.port});
    asio::write(noise, asio::buffer(std::string("GET / HTTP/1.1\r\n\r\n")));
    std::array<char, 100> answer{};
    asio::error_code ec;
    while (!ec) {
        noise.read_some(asio::buffer(answer), ec);
    }
    TlsClient good;
    EXPECT_TRUE(good.connect(server.port));
    ASSERT_TRUE(server.wait([&] { return server.opened.size() == 1; }));
    EXPECT_EQ(server.stats().handshake_failed, 2U);
    // They were never opened.
    EXPECT_TRUE(server.wait([&] { return server.closed.empty(); }));
}

TEST(TlsListener, GivesUpOnAHandshakeThatDoesNotCome) {
    const StateDir dir;
    TlsSettings settings = settings_in(dir);
    settings.limits.handshake_timeout_s = 0.05;
    Server server(settings);
    asio::io_context io;
    asio::ip::tcp::socket silent(io);
    silent.connect({asio::ip::make_address("127.0.0.1"), server.port});
    std::array<char, 10> answer{};
    asio::error_code ec;
    silent.read_some(asio::buffer(answer), ec);
    EXPECT_TRUE(ec);
    EXPECT_EQ(server.stats().handshake_timeout, 1U);
}

TEST(TlsListener, TakesNoMoreConnectionsThanItMay) {
    const StateDir dir;
    TlsSettings settings = settings_in(dir);
    settings.max_connections = 2;
    Server server(settings);
    TlsClient a;
    TlsClient b;
    TlsClient c;
    EXPECT_TRUE(a.connect(server.port));
    EXPECT_TRUE(b.connect(server.port));
    EXPECT_FALSE(c.connect(server.port));
    EXPECT_EQ(server.stats().refused_total, 1U);
    a.close();
    ASSERT_TRUE(server.wait([&] { return server.closed.size() == 1; }));
    TlsClient d;
    EXPECT_TRUE(d.connect(server.port));
}

TEST(TlsListener, LetsWhoComesTooFastWait) {
    const StateDir dir;
    TlsSettings settings = settings_in(dir);
    settings.max_handshakes_per_s = 20.0;
    Server server(settings);
    const auto begin = std::chrono::steady_clock::now();
    for (int i = 0; i < 25; ++i) {
        TlsClient client;
        ASSERT_TRUE(client.connect(server.port));
    }
    // At most a second's worth runs ahead: 25 at 20 a second take at least (25 - 1 - 20) / 20 s.
    EXPECT_GE(std::chrono::steady_clock::now() - begin, 190ms);
    EXPECT_EQ(server.stats().accepted, 25U);
}

/// A client that connects and may send some bytes of a handshake.
class HalfOpen {
  public:
    explicit HalfOpen(std::uint16_t port, const std::string& from = "127.0.0.1") {
        socket_.open(asio::ip::tcp::v4());
        socket_.bind({asio::ip::make_address(from), 0});
        socket_.connect({asio::ip::make_address("127.0.0.1"), port});
    }

    void send(const std::string& bytes) { asio::write(socket_, asio::buffer(bytes)); }

    /// True where the server ends the connection.
    bool ended() {
        std::array<char, 64> answer{};
        asio::error_code ec;
        while (!ec) {
            socket_.read_some(asio::buffer(answer), ec);
        }
        return true;
    }

    /// A record that says it is a handshake of so many bytes, and as many of them as given.
    static std::string record(std::size_t announced, std::size_t given) {
        std::string out{"\x16\x03\x01", 3};
        out += static_cast<char>(announced >> 8U);
        out += static_cast<char>(announced & 0xFFU);
        return out + std::string(given, '\xFF');
    }

  private:
    asio::io_context io_;
    asio::ip::tcp::socket socket_{io_};
};

/// At one handshake in 20 s a single one of a hundred would keep the honest client out for longer
/// than it waits.
TEST(TlsListener, ChargesNobodyForConnectionsThatComeAndGo) {
    const StateDir dir;
    TlsSettings settings = settings_in(dir);
    settings.max_handshakes_per_s = 0.05;
    Server server(settings);
    for (int i = 0; i < 50; ++i) {
        HalfOpen silent(server.port);
        HalfOpen partial(server.port);
        partial.send(HalfOpen::record(200, 100));
    }
    TlsClient honest;
    ASSERT_TRUE(honest.connect(server.port)) << honest.error.message();
    ASSERT_TRUE(server.wait([&] { return server.opened.size() == 1; }));
    for (int i = 0; i < 1000 && server.stats().left_early < 100; ++i) {
        std::this_thread::sleep_for(5ms);
    }
    EXPECT_EQ(server.stats().left_early, 100U);
    EXPECT_EQ(server.stats().handshake_failed, 0U);
}

TEST(TlsListener, StartsAHandshakeOnceItsFirstMessageIsWhole) {
    const StateDir dir;
    TlsSettings settings = settings_in(dir);
    settings.limits.handshake_timeout_s = 0.2;
    Server hasty(settings);
    HalfOpen partial(hasty.port);
    partial.send(HalfOpen::record(200, 199));
    EXPECT_TRUE(partial.ended());
    EXPECT_EQ(hasty.stats().handshake_timeout, 1U);
    // The whole of it is no message that OpenSSL takes: it began, and failed.
    const StateDir other;
    Server server(settings_in(other));
    HalfOpen whole(server.port);
    const std::string bytes = HalfOpen::record(200, 200);
    for (const char c : bytes) {
        whole.send(std::string(1, c));
    }
    EXPECT_TRUE(whole.ended());
    EXPECT_EQ(server.stats().handshake_failed, 1U);
    EXPECT_EQ(server.stats().handshake_timeout, 0U);
    EXPECT_EQ(server.connections(), 0U);
}

/// Each of them alone would have the whole time.
TEST(TlsListener, GivesOneTimeToTheFirstMessageAndTheRestOfTheHandshake) {
    const StateDir dir;
    TlsSettings settings = settings_in(dir);
    settings.limits.handshake_timeout_s = 1.0;
    Server server(settings);
    const auto begin = std::chrono::steady_clock::now();
    HalfOpen silent(server.port);
    std::this_thread::sleep_for(800ms);
    silent.send(TlsClient::client_hello());
    EXPECT_TRUE(silent.ended());
    const auto after = std::chrono::steady_clock::now() - begin;
    EXPECT_GE(after, 990ms);
    EXPECT_LT(after, 1500ms);
    EXPECT_EQ(server.stats().handshake_timeout, 1U);
}

TEST(TlsListener, SaysHowLongAClientTookToOpenItsStream) {
    const StateDir dir;
    Server server(settings_in(dir));
    TlsClient slow;
    ASSERT_TRUE(slow.connect(server.port, "127.0.0.1", 200ms)) << slow.error.message();
    ASSERT_TRUE(server.wait([&] { return server.opened.size() == 1; }));
    EXPECT_GE(server.spent_s.at(0), 0.19);
}

TEST(TlsListener, DropsWhatIsNoTlsAtItsFirstByte) {
    const StateDir dir;
    Server server(settings_in(dir));
    HalfOpen http(server.port);
    http.send("G");
    EXPECT_TRUE(http.ended());
    HalfOpen too_long(server.port);
    too_long.send(HalfOpen::record(16385, 0));
    EXPECT_TRUE(too_long.ended());
    EXPECT_EQ(server.stats().handshake_failed, 2U);
}

/// Forty handshakes of one address wait at two a second; one of another address comes last, and
/// is among the first that start all the same.
TEST(TlsListener, TakesTurnsAmongAddresses) {
    const StateDir dir;
    TlsSettings settings = settings_in(dir);
    settings.max_handshakes_per_s = 2.0;
    Server server(settings);
    std::vector<std::unique_ptr<HalfOpen>> flood;
    for (int i = 0; i < 40; ++i) {
        flood.push_back(std::make_unique<HalfOpen>(server.port, "127.0.0.2"));
        flood.back()->send(HalfOpen::record(200, 200));
    }
    TlsClient honest;
    ASSERT_TRUE(honest.connect(server.port)) << honest.error.message();
    ASSERT_TRUE(server.wait([&] { return server.opened.size() == 1; }));
    // A second's worth ran ahead before it came, and then every other one is of the flood. Others
    // come due while this machine is slow, but not half of the flood in the time of a handshake.
    EXPECT_LT(server.stats().handshake_failed, 20U);
}

TEST(TlsListener, ServesBothFamiliesAndNamesAPortInUse) {
    const StateDir dir;
    Server server(settings_in(dir, "::"));
    TlsClient v4;
    TlsClient v6;
    EXPECT_TRUE(v4.connect(server.port, "127.0.0.1"));
    EXPECT_TRUE(v6.connect(server.port, "::1"));
    ASSERT_TRUE(server.wait([&] { return server.opened.size() == 2; }));
    EXPECT_TRUE(server.all_loopback);
    TlsSettings taken = settings_in(dir, "::");
    taken.port = server.port;
    asio::io_context io;
    try {
        const TlsListener second(io, taken, {});
        FAIL() << "the port was given out twice";
    } catch (const std::system_error& e) {
        EXPECT_EQ(e.code(), std::errc::address_in_use);
        EXPECT_THAT(e.what(), testing::HasSubstr("TCP [::]:" + std::to_string(server.port)));
    }
}

TEST(TlsListener, StopsWithOpenStreams) {
    const StateDir dir;
    Server server(settings_in(dir));
    TlsClient client;
    ASSERT_TRUE(client.connect(server.port));
    ASSERT_TRUE(server.wait([&] { return server.opened.size() == 1; }));
    server.stop();
    EXPECT_EQ(client.receive(), "");
    EXPECT_TRUE(client.error);
}

TEST(Certificate, IsMadeOncePrivatelyAndUsedAgain) {
    const StateDir dir;
    TlsSettings settings = settings_in(dir);
    settings.certificate.state_dir = dir.path + "/deeper/still";
    std::string first;
    {
        Server server(settings);
        TlsClient client;
        ASSERT_TRUE(client.connect(server.port));
        first = server.fingerprint;
        EXPECT_EQ(first.size(), 64U);
        EXPECT_EQ(client.fingerprint(), first);
    }

    struct stat info {};

    for (const char* name : {"key.pem", "certificate.pem"}) {
        const std::string path = settings.certificate.state_dir + "/" + name;
        ASSERT_EQ(::stat(path.c_str(), &info), 0) << path;
        EXPECT_EQ(info.st_mode & 0777, 0600) << path;
    }
    Server again(settings);
    EXPECT_EQ(again.fingerprint, first);
    const StateDir other;
    Server different(settings_in(other));
    EXPECT_NE(different.fingerprint, first);
}

void expect_complaint(const CertificateSettings& settings, const std::string& text) {
    try {
        const auto context = make_server_context(prepare_certificate(settings));
        FAIL() << "expected: " << text;
    } catch (const std::runtime_error& e) {
        EXPECT_THAT(e.what(), testing::HasSubstr(text));
    }
}

TEST(Certificate, SaysWhatIsWrongWithConfiguredFiles) {
    const StateDir one;
    const StateDir two;
    const auto pair = prepare_certificate({"", "", one.path});
    const auto other = prepare_certificate({"", "", two.path});
    EXPECT_TRUE(pair.self_signed);
    EXPECT_NO_THROW(static_cast<void>(
        make_server_context(prepare_certificate({pair.certificate, pair.key, ""}))));
    expect_complaint({pair.certificate, "", ""}, "must be configured together");
    expect_complaint({one.path + "/none.pem", pair.key, ""}, "none.pem does not exist");
    expect_complaint({pair.certificate, one.path + "/none.pem", ""}, "the key file");
    expect_complaint({pair.certificate, other.key, ""}, "does not belong to the certificate");
    expect_complaint({pair.key, pair.key, ""}, "holds no certificate");
    expect_complaint({pair.certificate, pair.certificate, ""}, "holds no private key");
    std::filesystem::remove(one.path + "/key.pem");
    expect_complaint({"", "", one.path}, "but not key.pem");
    std::ofstream(two.path + "/file") << "x";
    expect_complaint({"", "", two.path + "/file"}, "state folder");
    if (geteuid() != 0) {
        std::filesystem::permissions(other.key, std::filesystem::perms::none);
        expect_complaint({other.certificate, other.key, ""}, "cannot be read");
    }
}

}  // namespace
}  // namespace zoned::net
