// The promises of a board, for each kind of board.
#include "server/cluster/local_board.h"
#include "server/cluster/nats_board.h"
#include "server/net/certificate.h"
#include "tests/harness/nats_server.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <condition_variable>
#include <cstdlib>
#include <mutex>
#include <set>
#include <thread>

namespace zoned::cluster {

namespace {

using zoned::test::NatsServer;

/// Some boards of one realm, as several servers have them.
class Realm {
  public:
    Realm() = default;
    Realm(const Realm&) = delete;
    Realm& operator=(const Realm&) = delete;
    virtual ~Realm() = default;
    virtual std::unique_ptr<Board> board() = 0;
};

class LocalRealm final : public Realm {
  public:
    std::unique_ptr<Board> board() override { return make_local_board(hub_); }

  private:
    std::shared_ptr<LocalHub> hub_ = make_local_hub();
};

NatsServer& nats() {
    static NatsServer server;
    return server;
}

class NatsRealm final : public Realm {
  public:
    std::unique_ptr<Board> board() override {
        NatsSettings settings;
        settings.urls = {nats().url()};
        settings.realm = realm_;
        auto made = connect_nats_board(settings);
        EXPECT_TRUE(made.ok()) << made.error();
        return made.ok() ? std::move(*made) : nullptr;
    }

  private:
    static std::string next_name() {
        static int realms = 0;
        return "t" + std::to_string(++realms);
    }

    std::string realm_ = next_name();
};

class AnyBoard : public ::testing::TestWithParam<const char*> {
  protected:
    void SetUp() override {
        if (std::string(GetParam()) == "Local") {
            realm = std::make_unique<LocalRealm>();
        } else {
            ASSERT_TRUE(NatsServer::installed()) << "install nats-server (config/packages.txt)";
            realm = std::make_unique<NatsRealm>();
        }
        a = realm->board();
        b = realm->board();
        ASSERT_TRUE(a && b);
    }

    std::unique_ptr<Realm> realm;
    std::unique_ptr<Board> a;
    std::unique_ptr<Board> b;
};

std::uint64_t put(Board& board, const std::string& key, std::uint64_t at, const std::string& text) {
    const auto done = board.put_if(key, at, text);
    EXPECT_TRUE(done.ok()) << done.error().text;
    return done.ok() ? *done : 0;
}

}  // namespace

TEST_P(AnyBoard, GivesBackWhatAnotherServerWrote) {
    const auto nothing = b->get("world.castle");
    ASSERT_TRUE(nothing.ok());
    EXPECT_FALSE(nothing->has_value());
    const std::string odd("a\0b\xFF\n", 5);
    const std::uint64_t revision = put(*a, "world.castle", 0, odd);
    const auto found = b->get("world.castle");
    ASSERT_TRUE(found.ok() && *found);
    EXPECT_EQ((*found)->value, odd);
    EXPECT_EQ((*found)->revision, revision);
}

TEST_P(AnyBoard, WritesUnderTheExpectedRevisionAlone) {
    const std::uint64_t first = put(*a, "k.x", 0, "1");
    for (const std::uint64_t wrong : {std::uint64_t{0}, first + 1, first + 1000}) {
        const auto refused = b->put_if("k.x", wrong, "no");
        ASSERT_FALSE(refused.ok());
        EXPECT_EQ(refused.error().fault, BoardFault::kChanged);
    }
    const std::uint64_t second = put(*b, "k.x", first, "2");
    EXPECT_GT(second, first);
    const auto late = a->put_if("k.x", first, "late");
    ASSERT_FALSE(late.ok());
    EXPECT_EQ(late.error().fault, BoardFault::kChanged);
    EXPECT_EQ((*a->get("k.x"))->value, "2");
}

TEST_P(AnyBoard, RevisionsAscendOverAllKeys) {
    std::uint64_t newest = 0;
    for (int i = 0; i < 20; ++i) {
        const std::uint64_t revision = put(i % 2 == 0 ? *a : *b, "k." + std::to_string(i), 0, "x");
        EXPECT_GT(revision, newest);
        newest = revision;
    }
}

TEST_P(AnyBoard, OneOfManyWritersWins) {
    constexpr int kWriters = 4;
    constexpr int kKeys = 50;
    std::vector<std::unique_ptr<Board>> boards;
    std::vector<std::thread> threads;
    std::array<std::atomic<int>, kKeys> won{};
    for (int w = 0; w < kWriters; ++w) {
        boards.push_back(realm->board());
    }
    for (int w = 0; w < kWriters; ++w) {
        threads.emplace_back([&, w] {
            for (int k = 0; k < kKeys; ++k) {
                if (boards[static_cast<std::size_t>(w)]
                        ->put_if("race." + std::to_string(k), 0, std::to_string(w))
                        .ok()) {
                    ++won[static_cast<std::size_t>(k)];
                }
            }
        });
    }
    for (std::thread& thread : threads) {
        thread.join();
    }
    for (int k = 0; k < kKeys; ++k) {
        EXPECT_EQ(won[static_cast<std::size_t>(k)].load(), 1) << k;
    }
}

TEST_P(AnyBoard, ListsTheKeysOfAPrefixAlone) {
    put(*a, "world.castle", 0, "1");
    put(*a, "world.meadow", 0, "2");
    put(*a, "worlds.other", 0, "3");
    put(*a, "account.00", 0, "4");
    const auto listed = b->list("world");
    ASSERT_TRUE(listed.ok()) << listed.error().text;
    std::set<std::string> keys;
    for (const auto& [key, entry] : *listed) {
        keys.insert(key + "=" + entry.value);
        EXPECT_GT(entry.revision, 0U);
    }
    EXPECT_EQ(keys, (std::set<std::string>{"world.castle=1", "world.meadow=2"}));
    const auto none = b->list("nothing");
    ASSERT_TRUE(none.ok()) << none.error().text;
    EXPECT_TRUE(none->empty());
}

TEST_P(AnyBoard, MessagesReachThoseThatHearTheirSubject) {
    std::mutex mutex;
    std::condition_variable changed;
    std::vector<std::string> heard;
    const auto hear = [&](const std::string& bytes) {
        const std::lock_guard lock(mutex);
        heard.push_back(bytes);
        changed.notify_all();
    };
    auto one = a->subscribe("world.castle", hear);
    const auto other = a->subscribe("world.meadow", [](const std::string&) { ADD_FAILURE(); });
    ASSERT_TRUE(one && other);
    const std::string odd("\0\xFF", 2);
    b->publish("world.castle", odd);
    b->publish("world.castle", "");
    {
        std::unique_lock lock(mutex);
        ASSERT_TRUE(
            changed.wait_for(lock, std::chrono::seconds(5), [&] { return heard.size() == 2; }));
        EXPECT_EQ(heard, (std::vector<std::string>{odd, ""}));
    }
    one.reset();
    b->publish("world.castle", "too late");
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
    const std::lock_guard lock(mutex);
    EXPECT_EQ(heard.size(), 2U);
}

TEST_P(AnyBoard, TakesValuesOfSomeHundredKilobytes) {
    const std::string large(900'000, 'x');
    const std::uint64_t revision = put(*a, "account.ab", 0, large);
    EXPECT_EQ((*b->get("account.ab"))->value, large);
    put(*b, "account.ab", revision, "small");
}

INSTANTIATE_TEST_SUITE_P(Boards,
                         AnyBoard,
                         ::testing::Values("Local", "Nats"),
                         [](const auto& kind) { return std::string(kind.param); });

class NatsAlone : public ::testing::Test {
  protected:
    void SetUp() override {
        ASSERT_TRUE(NatsServer::installed()) << "install nats-server (config/packages.txt)";
    }

    static core::Result<std::unique_ptr<Board>> connect(const std::string& url,
                                                        double patience_s = 2.0) {
        NatsSettings settings;
        settings.urls = {url};
        settings.patience_s = patience_s;
        return connect_nats_board(settings);
    }

    template <class Done>
    static bool within_10_s(Done done) {
        for (int i = 0; i < 500 && !done(); ++i) {
            std::this_thread::sleep_for(std::chrono::milliseconds(20));
        }
        return done();
    }
};

TEST_F(NatsAlone, KeepsWhatWasWrittenOverAKillAndGoesOnByItself) {
    NatsServer server;
    const auto made = connect(server.url());
    ASSERT_TRUE(made.ok()) << made.error();
    Board& board = **made;
    const std::uint64_t revision = put(board, "k.x", 0, "kept");
    std::atomic<int> heard{0};
    const auto subscription = board.subscribe("s", [&](const std::string&) { ++heard; });
    server.kill();
    EXPECT_TRUE(within_10_s([&] { return !board.connected(); }));
    const auto cut = board.put_if("k.x", revision, "lost");
    ASSERT_FALSE(cut.ok());
    EXPECT_EQ(cut.error().fault, BoardFault::kUnreachable) << cut.error().text;
    EXPECT_FALSE(board.get("k.x").ok());
    server.start();
    ASSERT_TRUE(within_10_s([&] { return board.connected(); }));
    std::string kept;
    // A later question may fail again: JetStream comes after the connection.
    ASSERT_TRUE(within_10_s([&] {
        const auto found = board.get("k.x");
        kept = found.ok() && *found ? (*found)->value : "";
        return found.ok();
    }));
    EXPECT_EQ(kept, "kept");
    EXPECT_GT(put(board, "k.x", revision, "more"), revision);
    EXPECT_TRUE(within_10_s([&] {
        board.publish("s", "x");
        return heard > 0;
    })) << "subscriptions come back with the connection";
}

TEST_F(NatsAlone, AWriteWithoutAnswerIsNeitherDoneNorFailed) {
    const NatsServer server;
    const auto made = connect(server.url(), 1.0);
    ASSERT_TRUE(made.ok()) << made.error();
    Board& board = **made;
    const std::uint64_t revision = put(board, "k.x", 0, "1");
    server.pause();
    const auto doubtful = board.put_if("k.x", revision, "2");
    server.go_on();
    ASSERT_FALSE(doubtful.ok());
    EXPECT_EQ(doubtful.error().fault, BoardFault::kUnknown) << doubtful.error().text;
    // This one arrived when the server went on.
    EXPECT_TRUE(within_10_s([&] {
        const auto found = board.get("k.x");
        return found.ok() && *found && (*found)->value == "2";
    }));
}

TEST_F(NatsAlone, AsksForUserAndPasswordOrTokenAndRepeatsNone) {
    const NatsServer of_user({"--user", "ann", "--pass", "secret7"});
    const std::string place = "127.0.0.1:" + std::to_string(of_user.port());
    EXPECT_TRUE(connect("nats://ann:secret7@" + place).ok());
    const auto wrong = connect("nats://ann:secret8@" + place);
    ASSERT_FALSE(wrong.ok());
    EXPECT_EQ(wrong.error().find("secret"), std::string::npos) << wrong.error();
    EXPECT_NE(wrong.error().find(place), std::string::npos) << wrong.error();
    EXPECT_FALSE(connect(of_user.url()).ok());

    const NatsServer of_token({"--auth", "t0ken"});
    const std::string other = "127.0.0.1:" + std::to_string(of_token.port());
    EXPECT_TRUE(connect("nats://t0ken@" + other).ok());
    EXPECT_FALSE(connect("nats://token@" + other).ok());
}

TEST_F(NatsAlone, EncryptsAndTalksToAServerOfATrustedAuthorityAlone) {
    net::CertificateSettings made;
    made.state_dir = ::testing::TempDir() + "zoned_nats_tls";
    const net::CertificateFiles files = net::prepare_certificate(made);
    const NatsServer server({"--tls", "--tlscert", files.certificate, "--tlskey", files.key});
    const std::string url = "tls://127.0.0.1:" + std::to_string(server.port());
    const auto stranger = connect(url);
    EXPECT_FALSE(stranger.ok()) << "nobody vouches for its certificate";
    ASSERT_EQ(::setenv("SSL_CERT_FILE", files.certificate.c_str(), 1), 0);
    const auto known = connect(url);
    ::unsetenv("SSL_CERT_FILE");
    ASSERT_TRUE(known.ok()) << known.error();
    put(**known, "k.x", 0, "1");
}

TEST_F(NatsAlone, SaysWhatIsMissing) {
    const auto nobody = connect("nats://127.0.0.1:1");
    ASSERT_FALSE(nobody.ok());
    EXPECT_NE(nobody.error().find("is a NATS server running"), std::string::npos) << nobody.error();
}

}  // namespace zoned::cluster
