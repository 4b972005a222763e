// Players go from the world of one server to that of another, and the servers find each other.
#include "server/cluster/accounts.h"
#include "tests/integration/cluster/realm.h"

#include <algorithm>
#include <chrono>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <set>
#include <thread>

namespace zoned::testing_cluster {
namespace {

class Travel : public Realm {};

TEST_F(Travel, APlayerGoesToAndFroWithAllThatTheStoreKeeps) {
    begin(2);
    enter_the_castle();
    std::set<std::string> worlds;
    ASSERT_TRUE(play_until(
        [&] {
            worlds.insert(players[0]->world);
            return travels() >= 8;
        },
        kPatience))
        << castle.server->errors() << meadow.server->errors();
    EXPECT_EQ(worlds, (std::set<std::string>{"castle", "meadow"}));
    settle();
    EXPECT_EQ(players[0]->stats().sessions_lost, 0U);
    end();
    expect_clean();
    EXPECT_NE(castle.server->errors().find("account player0 went to the world meadow"),
              std::string::npos);
}

TEST_F(Travel, AWorldThatPlayersLeaveAndEnterReplaysWithoutItsCluster) {
    recorded = true;
    begin(3);
    enter_the_castle();
    ASSERT_TRUE(play_until([&] { return travels() >= 9; }, kPatience));
    end();
    nats->kill();
    for (const char* name : {"castle", "meadow"}) {
        EXPECT_EQ(zoned({"replay", folder + "/" + name + ".zrec"}), 0) << said << complained;
        EXPECT_NE(said.find("every hash agrees"), std::string::npos) << said;
    }
}

TEST_F(Travel, RulesSendPlayersToAndFro) {
    by_rules = true;
    recorded = true;
    begin(2);
    enter_the_castle();
    ASSERT_TRUE(play_until([&] { return travels() >= 6; }, kPatience))
        << castle.server->errors() << meadow.server->errors();
    settle();
    end();
    expect_clean();
    // The second call named a client that is not there.
    EXPECT_NE(castle.server->errors().find("true false"), std::string::npos);
    nats->kill();
    EXPECT_EQ(zoned({"replay", folder + "/castle.zrec"}), 0) << said << complained;
    EXPECT_NE(said.find("every hash agrees"), std::string::npos) << said;
}

TEST_F(Travel, TheCheckerSeesACharacterInTwoWorlds) {
    begin(3, {"testing.travel.keep_avatar=true"});
    enter_the_castle();
    ASSERT_TRUE(play_until([&] { return travels() >= 3; }, kPatience));
    settle();
    end();
    const std::vector<TravelFinding> found = findings();
    ASSERT_FALSE(found.empty());
    EXPECT_EQ(found.front().wrong, TravelFinding::Wrong::kTwoOwners) << found.front().text;
}

TEST_F(Travel, TheCheckerSeesWhatGotLost) {
    begin(3, {"testing.travel.lose_records=true"});
    enter_the_castle();
    ASSERT_TRUE(play_until([&] { return travels() >= 3; }, kPatience));
    settle();
    end();
    const std::vector<TravelFinding> found = findings();
    ASSERT_FALSE(found.empty());
    EXPECT_EQ(found.front().wrong, TravelFinding::Wrong::kLost) << found.front().text;
}

TEST_F(Travel, TheCheckerTellsWhatIsDoubledFromWhatIsLost) {
    begin(4);
    enter_the_castle();
    settle();
    end();
    expect_clean();
    const auto realm = board();
    ASSERT_TRUE(realm);
    // On their way with no token, with another's, with two, and with the right one.
    const std::vector<std::vector<std::string>> tokens{
        {}, {"player0"}, {"player2", "player2"}, {"player3"}};
    for (std::size_t i = 0; i < tokens.size(); ++i) {
        const std::string key = cluster::Accounts::key_of(players[i]->account());
        const auto found = realm->get(key);
        ASSERT_TRUE(found.ok() && *found);
        proto::cluster::AccountEntry entry;
        ASSERT_TRUE(entry.ParseFromString((*found)->value));
        entry.set_state(proto::cluster::ACCOUNT_ON_ITS_WAY);
        entry.clear_records();
        for (const std::string& owner : tokens[i]) {
            auto& record = *entry.add_records();
            record.set_key("token");
            record.set_value("the token of " + owner);
        }
        ASSERT_TRUE(realm->put_if(key, (*found)->revision, entry.SerializeAsString()).ok());
    }
    std::vector<TravelFinding::Wrong> wrong;
    for (const TravelFinding& finding : findings()) {
        wrong.push_back(finding.wrong);
    }
    using Wrong = TravelFinding::Wrong;
    EXPECT_EQ(wrong, (std::vector{Wrong::kLost, Wrong::kLost, Wrong::kDoubled}));
}

TEST_F(Travel, PlayGoesOnWithoutTheNatsServerAndTravelWaits) {
    portal_wait_s = 1.0;
    begin(6);
    enter_the_castle();
    ASSERT_TRUE(play_until([&] { return travels() >= 6; }, kPatience));
    settle();
    nats->kill();
    const std::uint64_t still = travels();
    std::vector<int> joins;
    for (const auto& player : players) {
        joins.push_back(player->joins);
    }
    play_until([] { return false; }, 3.0);
    EXPECT_EQ(travels(), still);
    EXPECT_TRUE(all_play()) << "whoever is in a world stays there";
    for (std::size_t i = 0; i < players.size(); ++i) {
        EXPECT_EQ(players[i]->joins, joins[i]) << "in the same session";
    }
    nats->start();
    EXPECT_TRUE(play_until([&] { return travels() >= still + 12; }, kPatience))
        << castle.server->errors() << meadow.server->errors();
    settle();
    end();
    expect_clean();
}

TEST_F(Travel, AServerWhoseLeaseEndedTakesNobodyInUntilItIsRenewed) {
    cluster_lines = "lease_s: 1";
    begin(2);
    enter_the_castle();
    nats->kill();
    ASSERT_TRUE(play_until(
        [&] {
            return castle.server->errors().find("the lease of the world castle has ended") !=
                   std::string::npos;
        },
        kPatience));
    // Without a lease a login is refused; those inside play on.
    add("late");
    EXPECT_TRUE(play_until(
        [&] {
            return players.back()->trouble().find("lost touch with its cluster") !=
                   std::string::npos;
        },
        kPatience))
        << players.back()->trouble();
    play_until([] { return false; }, 1.0);
    EXPECT_EQ(players.back()->joins, 0);
    nats->start();
    EXPECT_TRUE(play_until([&] { return players.back()->joins > 0; }, kPatience))
        << castle.server->errors();
    // The log has a thread of its own, and may come after the login.
    EXPECT_TRUE(castle.server->wait_for_errors("is renewed again", kPatience))
        << castle.server->errors();
    end();
}

TEST_F(Travel, AStandbyTakesTheWorldWhenItsServerStopsOrDies) {
    cluster_lines = "lease_s: 6";
    begin(1);
    World standby{"castle", {}, {}, 0, nullptr};
    write_config(standby, "meadow", "");
    standby.state = folder + "/standby-state";
    start(standby, {}, false);
    EXPECT_FALSE(standby.server->wait_for_output("ready ", 3.0)) << "the castle has its server";
    EXPECT_NE(standby.server->errors().find("waits to take its place"), std::string::npos)
        << standby.server->errors();
    double begun = now_s();
    stop(castle);
    wait_until_ready(standby);
    EXPECT_LT(now_s() - begun, 5.5) << "what was given back needs no wait";
    // Dead, the other way round, with another state folder: after the lease.
    start(castle, {}, false);
    EXPECT_FALSE(castle.server->wait_for_output("ready ", 1.0));
    begun = now_s();
    standby.server->signal(SIGKILL);
    ASSERT_EQ(standby.server->wait(kPatience), 128 + SIGKILL);
    wait_until_ready(castle);
    EXPECT_GT(now_s() - begun, 4.5);
    EXPECT_LT(now_s() - begun, 60.0);
    // The next process of the same state folder need not wait.
    castle.server->signal(SIGKILL);
    castle.server->wait(kPatience);
    begun = now_s();
    start(castle);
    EXPECT_LT(now_s() - begun, 5.5);
    stop(castle);
    stop(meadow);
}

TEST_F(Travel, OperatorsSeeAndDrainTheServersOfARealm) {
    begin(1);
    EXPECT_EQ(zoned({"cluster", "status", "--cluster", nats->url()}), 0) << complained;
    EXPECT_NE(said.find("castle           open"), std::string::npos) << said;
    EXPECT_NE(said.find("meadow           open"), std::string::npos) << said;
    EXPECT_EQ(zoned({"cluster", "status", "--json", "--cluster", nats->url()}), 0);
    EXPECT_NE(said.find("{\"world\": \"castle\", \"state\": \"open\""), std::string::npos) << said;
    EXPECT_EQ(zoned({"ctl", "--state", castle.state, "metrics"}), 0) << complained;
    for (const char* metric : {"zoned_cluster_lease_held 1",
                               "zoned_cluster_connected 1",
                               "zoned_cluster_travels_total{direction=\"in\"} 0"}) {
        EXPECT_NE(said.find(metric), std::string::npos) << metric;
    }
    EXPECT_EQ(zoned({"cluster", "drain", "tower", "--cluster", nats->url()}), 1);
    EXPECT_NE(complained.find("no server has the world tower"), std::string::npos) << complained;
    EXPECT_EQ(zoned({"cluster", "drain", "meadow", "--grace-s", "1", "--cluster", nats->url()}), 0)
        << complained;
    EXPECT_EQ(meadow.server->wait(kPatience), 0) << meadow.server->errors();
    EXPECT_EQ(zoned({"cluster", "status", "--cluster", nats->url()}), 0);
    EXPECT_NE(said.find("meadow           free"), std::string::npos) << said;
    stop(castle);
    EXPECT_EQ(zoned({"cluster", "status", "--cluster", "nats://u:hush@127.0.0.1:1"}), 3);
    EXPECT_EQ(complained.find("hush"), std::string::npos) << complained;
    EXPECT_EQ(zoned({"cluster", "status", "--cluster", "http://u:hush@127.0.0.1:1"}), 2);
    EXPECT_EQ(complained.find("hush"), std::string::npos) << complained;
    // A server waits for a NATS server that is not there, and its log repeats no secret.
    Child waits("zoned",
                {"serve",
                 "--config",
                 castle.config,
                 "--set",
                 "session.state_folder=\"" + castle.state + "\"",
                 "--set",
                 "session.ticket_public_key_file=\"" + folder + "/login.pub\"",
                 "--cluster",
                 "nats://u:hush@127.0.0.1:1"});
    EXPECT_TRUE(waits.wait_for_errors("trying again", kPatience));
    EXPECT_NE(waits.errors().find("cannot connect to the cluster at nats://127.0.0.1:1"),
              std::string::npos)
        << waits.errors();
    EXPECT_EQ(waits.errors().find("hush"), std::string::npos) << waits.errors();
    EXPECT_EQ(zoned({"serve",
                     "--config",
                     ZONED_SOURCE_DIR "/config/minimal.txtpb",
                     "--cluster",
                     nats->url()}),
              2);
    EXPECT_NE(complained.find("set cluster.name"), std::string::npos) << complained;
}

TEST_F(Travel, BotsAreSentToTheWorldThatTheyAskFor) {
    portal_wait_s = 60.0;
    begin(1, {"session.dev_rights=[PLAY, AUDIT, FREEZE]", "session.dev_mode_loopback=true"});
    const auto ask = [&](const std::string& world) {
        Child bots("client-sim",
                   {"--connect",
                    "127.0.0.1:" + std::to_string(castle.port),
                    "--world",
                    world,
                    "--bots",
                    "3",
                    "--seconds",
                    "2",
                    "--quiet",
                    "--report",
                    folder + "/report.json"});
        const int code = bots.wait(kPatience);
        said = bots.output() + bots.errors();
        return code;
    };
    EXPECT_EQ(ask("castle"), 0) << said;
    std::this_thread::sleep_for(std::chrono::seconds(1));  // directories are read once a second
    EXPECT_EQ(ask("meadow"), 0) << said;
    std::ifstream file(folder + "/report.json");
    const std::string report((std::istreambuf_iterator<char>(file)), {});
    EXPECT_NE(report.find("\"redirects\": 3"), std::string::npos) << report;
    EXPECT_NE(ask("tower"), 0);
    EXPECT_NE(said.find("no server of the cluster has the world tower"), std::string::npos) << said;
    stop(castle);
    stop(meadow);
}

TEST_F(Travel, TheVerdictOfBotsThatTravelIsConsistent) {
    portal_wait_s = 1.5;
    begin(1);
    std::ofstream tickets(folder + "/tickets.txt");
    for (int i = 0; i < 6; ++i) {
        EXPECT_EQ(zoned({"ticket",
                         "--key",
                         folder + "/login.key",
                         "--account",
                         "bot" + std::to_string(i),
                         "--right",
                         "play",
                         "--right",
                         "audit",
                         "--right",
                         "freeze"}),
                  0)
            << complained;
        tickets << said;
    }
    tickets.close();
    Child bots("client-sim",
               {"--connect",
                "127.0.0.1:" + std::to_string(castle.port),
                "--bots",
                "6",
                "--seconds",
                "8",
                "--ticket",
                folder + "/tickets.txt",
                "--quiet",
                "--report",
                folder + "/report.json"});
    EXPECT_EQ(bots.wait(kPatience), 0) << bots.output() << bots.errors();
    EXPECT_NE(bots.output().find("travels to another world"), std::string::npos) << bots.output();
    std::ifstream file(folder + "/report.json");
    const std::string report((std::istreambuf_iterator<char>(file)), {});
    EXPECT_GE(testing_process::number_after(report, "\"travels\": "), 12) << report;
    // A second and a half in the portal are enough to connect, but for the first time: servers that
    // have just started know each other after a second.
    EXPECT_GE(testing_process::number_after(report, "\"travels_prepared\": "),
              testing_process::number_after(report, "\"travels\": ") - 6)
        << report;
    EXPECT_NE(report.find("\"verdict\": \"consistent\""), std::string::npos) << report;
    stop(castle);
    stop(meadow);
}

}  // namespace
}  // namespace zoned::testing_cluster
