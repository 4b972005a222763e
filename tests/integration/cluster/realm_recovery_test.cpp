// Servers of a cluster are killed, and their worlds come back: with all who were there, and without
// those who had gone.
#include "server/app/world/replayed_tick.h"
#include "server/app/world/world.h"
#include "server/cluster/accounts.h"
#include "server/config/expand/load_settings.h"
#include "server/recording/recording_reader.h"
#include "tests/integration/cluster/realm.h"

#include <chrono>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <thread>

namespace zoned::testing_cluster {
namespace {

class RealmRecovery : public Realm {
  protected:
    void SetUp() override {
        Realm::SetUp();
        recovers = true;
    }

    void kill(World& world) {
        world.server->signal(SIGKILL);
        ASSERT_EQ(world.server->wait(kPatience), 128 + SIGKILL) << world.server->errors();
    }

    static void copy_journal(const World& world, const std::string& to) {
        std::filesystem::remove_all(to);
        std::filesystem::copy(
            world.state + "/journal", to, std::filesystem::copy_options::recursive);
    }

    static void expect_back(const World& world) {
        const std::string said = world.server->errors();
        EXPECT_NE(said.find("the world goes on after tick"), std::string::npos) << said;
        EXPECT_EQ(said.find("not all is as it was"), std::string::npos) << said;
    }

    /// Portals that nobody comes through by chance.
    void begin_without_travel(int count, const std::vector<std::string>& sets = {}) {
        portal_wait_s = 60.0;
        begin(count, sets);
        enter_the_castle();
        settle();
    }

    void play(double seconds) {
        play_until([] { return false; }, seconds);
    }
};

/// Simulates the ticks of a journal in `world`, from the first that it has not had; the number of
/// those whose hashes were compared.
std::size_t simulate(const std::string& folder, std::unique_ptr<app::World>& world) {
    static config::Settings settings;
    recording::RecordingReader reader;
    EXPECT_TRUE(reader.open(folder).ok());
    if (!world) {
        std::vector<config::ConfigError> errors;
        EXPECT_TRUE(config::parse_settings(reader.header().config_text, {}, settings, errors));
        world = std::make_unique<app::World>(settings, 1U, [] { return std::uint64_t{0}; });
    }
    std::size_t compared = 0;
    recording::TickRecord record;
    for (auto more = reader.next(record); more.ok() && *more; more = reader.next(record)) {
        if (record.tick <= world->now()) {
            continue;
        }
        const bool has_hashes = !record.hashes.empty();
        const std::string wrong = app::replayed_tick(settings, record, true, *world);
        EXPECT_EQ(wrong, "");
        if (!wrong.empty()) {
            return compared;
        }
        compared += has_hashes ? 1 : 0;
    }
    return compared;
}

TEST_F(RealmRecovery, PlayersComeBackToWorldsThatOthersLeaveAndEnter) {
    begin(8);
    enter_the_castle();
    // Each world once, and again where all were in the other one just then.
    for (int i = 0; i < 6 && (i < 2 || recovered() == 0); ++i) {
        World& world = i % 2 == 0 ? castle : meadow;
        play(1.3 + 0.21 * i);
        kill(world);
        start(world);
        expect_back(world);
        play_until([&] { return all_play(); }, kPatience);
    }
    EXPECT_GT(recovered(), 0U) << "some were there when it died";
    const std::uint64_t before = travels();
    EXPECT_TRUE(play_until([&] { return travels() > before + 12; }, kPatience))
        << castle.server->errors() << meadow.server->errors();
    settle();
    end();
    expect_clean();
}

TEST_F(RealmRecovery, ACourseOverTwoDeathsHasTheHashesOfOneWithout) {
    begin(6, {"recovery.snapshot_every_s=3600"});
    enter_the_castle();
    ASSERT_TRUE(play_until([&] { return travels() >= 9; }, kPatience));
    for (int i = 0; i < 2; ++i) {
        kill(castle);
        copy_journal(castle, folder + "/part" + std::to_string(i));
        start(castle, {"recovery.snapshot_every_s=3600"});
        expect_back(castle);
        const std::uint64_t before = travels();
        ASSERT_TRUE(play_until([&] { return travels() >= before + 18; }, kPatience));
    }
    kill(castle);
    copy_journal(castle, folder + "/part2");
    // One world, fed all that the three processes were fed.
    std::unique_ptr<app::World> world;
    for (int i = 0; i < 3; ++i) {
        EXPECT_GT(simulate(folder + "/part" + std::to_string(i), world), 5U) << "part " << i;
    }
    start(castle, {"recovery.snapshot_every_s=3600"});
    EXPECT_NE(castle.server->errors().find("the world goes on after tick " +
                                           std::to_string(world->now()) + ":"),
              std::string::npos)
        << world->now() << castle.server->errors();
    settle();
    end();
    expect_clean();
}

TEST_F(RealmRecovery, AnAccountThatWasGivenAwayIsNotInTheWorldThatComesBack) {
    const std::vector<std::string> sets{"recovery.snapshot_every_s=3600"};
    portal_wait_s = 2.0;
    begin(3, sets);
    enter_the_castle();
    play(0.5);
    // As if the disk had lied: what is on it is from before all three went to the meadow.
    kill(castle);
    copy_journal(castle, folder + "/before");
    start(castle, sets);
    expect_back(castle);
    meadow.server->signal(SIGSTOP);
    ASSERT_TRUE(play_until([&] { return !all_play(); }, kPatience));
    play(1.0);
    kill(castle);
    std::filesystem::remove_all(castle.state + "/journal");
    std::filesystem::copy(
        folder + "/before", castle.state + "/journal", std::filesystem::copy_options::recursive);
    start(castle, sets);
    expect_back(castle);
    EXPECT_NE(castle.server->errors().find("of 3 accounts in the world as it was, 3 are in"),
              std::string::npos)
        << castle.server->errors();
    // A server that has just come back has no figures before its first tick.
    const auto has_figures = [&] {
        return zoned({"ctl", "--state", castle.state, "metrics"}) == 0;
    };
    EXPECT_TRUE(play_until(has_figures, kPatience)) << complained;
    EXPECT_NE(said.find("zoned_recovery_sessions{account=\"elsewhere\"} 3"), std::string::npos)
        << said;
    EXPECT_NE(said.find("zoned_recovery_sessions{account=\"here\"} 0"), std::string::npos);
    meadow.server->signal(SIGCONT);
    EXPECT_TRUE(play_until([&] { return travels() >= 6; }, kPatience));
    settle();
    end();
    expect_clean();
}

TEST_F(RealmRecovery, NobodyIsGivenAwayWhileTheJournalFails) {
    namespace fs = std::filesystem;
    portal_wait_s = 6.0;
    begin(2, {"recovery.snapshot_every_s=1"});
    enter_the_castle();
    // The piece that begins with the next snapshot cannot be opened.
    fs::rename(castle.state + "/journal", castle.state + "/elsewhere");
    std::ofstream(castle.state + "/journal") << "no folder";
    ASSERT_TRUE(castle.server->wait_for_errors("a crash from here until the next snapshot", 5.0))
        << castle.server->errors();
    const auto leaves = [&] {
        std::ifstream journal(folder + "/journal");
        const std::string text((std::istreambuf_iterator<char>(journal)), {});
        return text.find(" end castle ") != std::string::npos;
    };
    ASSERT_FALSE(leaves()) << "later than the journal failed";
    ASSERT_TRUE(play_until(leaves, kPatience));
    play(2.0);
    EXPECT_EQ(travels(), 0U) << "a crash would bring them back here";
    fs::remove(castle.state + "/journal");
    fs::rename(castle.state + "/elsewhere", castle.state + "/journal");
    EXPECT_TRUE(play_until([&] { return travels() >= 2; }, kPatience)) << castle.server->errors();
    settle();
    end();
    expect_clean();
}

/// However often: starts that were asked to stop are no deaths, after which a world begins anew.
TEST_F(RealmRecovery, AServerThatWaitsForTheBoardCanBeStoppedAndItsWorldStays) {
    begin_without_travel(2);
    kill(castle);
    const auto realm = board();
    ASSERT_TRUE(realm);
    const std::string key = cluster::Accounts::key_of(players[0]->account());
    const auto good = realm->get(key);
    ASSERT_TRUE(good.ok() && *good);
    const auto bad = realm->put_if(key, (*good)->revision, "no entry at all");
    ASSERT_TRUE(bad.ok());
    for (int i = 0; i < 6; ++i) {
        start(castle, {}, false);
        ASSERT_TRUE(castle.server->wait_for_errors("cannot be read", kPatience))
            << castle.server->errors();
        castle.server->signal(i % 2 == 0 ? SIGTERM : SIGINT);
        EXPECT_EQ(castle.server->wait(kPatience), 3) << castle.server->errors();
        EXPECT_NE(castle.server->errors().find("what is kept of it stays"), std::string::npos)
            << castle.server->errors();
    }
    const auto now = realm->get(key);
    ASSERT_TRUE(now.ok() && *now);
    ASSERT_TRUE(realm->put_if(key, (*now)->revision, (*good)->value).ok());
    start(castle);
    expect_back(castle);
    EXPECT_TRUE(play_until([&] { return recovered() == 2; }, kPatience));
    settle();
    end();
    expect_clean();
}

TEST_F(RealmRecovery, AStandbyOfTheSameStateFolderGoesOnAtTheVeryTick) {
    begin_without_travel(4);
    World standby{"castle", castle.config, castle.state, castle.port, nullptr};
    start(standby, {}, false);
    EXPECT_TRUE(standby.server->wait_for_errors("this server waits to take its place", kPatience))
        << standby.server->errors();
    play(1.0);
    const double killed_s = now_s();
    kill(castle);
    wait_until_ready(standby);
    RecordProperty("seconds", std::to_string(now_s() - killed_s));
    EXPECT_LT(now_s() - killed_s, 6.0)
        << "the lock of the folder proves the death: no lease is waited for";
    expect_back(standby);
    EXPECT_TRUE(play_until([&] { return recovered() == 4; }, kPatience));
    settle();
    EXPECT_EQ(zoned({"ctl", "--state", castle.state, "metrics"}), 0) << complained;
    for (const char* metric : {"zoned_recoveries_total 1",
                               "zoned_recovery_seconds ",
                               "zoned_recovery_ticks ",
                               "zoned_recovery_tick ",
                               "zoned_recovery_sessions{account=\"here\"} 4"}) {
        EXPECT_NE(said.find(metric), std::string::npos) << metric;
    }
    castle.server = std::move(standby.server);
    end();
    expect_clean();
}

TEST_F(RealmRecovery, AWorldThatAnotherServerHadSinceBeginsAnew) {
    cluster_lines = "lease_s: 3";
    begin_without_travel(2);
    kill(castle);
    World standby{"castle", castle.config, folder + "/standby-state", castle.port, nullptr};
    start(standby);
    EXPECT_EQ(standby.server->errors().find("the world goes on"), std::string::npos)
        << "it has no state of the world";
    kill(standby);
    start(castle);
    const std::string said_by = castle.server->errors();
    EXPECT_NE(said_by.find("another server has had the world since"), std::string::npos) << said_by;
    EXPECT_EQ(said_by.find("the world goes on"), std::string::npos) << said_by;
    // From here on what it keeps is the world's.
    settle();
    kill(castle);
    start(castle);
    expect_back(castle);
    settle();
    end();
}

}  // namespace
}  // namespace zoned::testing_cluster
