// Players go from the world of one server to that of another, and the servers find each other.
#include "tests/integration/cluster/realm.h"

#include <algorithm>
#include <chrono>
#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <set>
#include <thread>

namespace zoned::testing_cluster {
namespace {

std::vector<std::string> accounts(int count) {
    std::vector<std::string> out;
    for (int i = 0; i < count; ++i) {
        out.push_back("player" + std::to_string(i));
    }
    return out;
}

/// As testing.proto names the steps.
std::string name_of_step(int step) {
    static constexpr const char* kNames[] = {"NONE",
                                             "WISHED",
                                             "PROBED",
                                             "FROZEN",
                                             "PACKED",
                                             "COMMITTED",
                                             "TOLD",
                                             "REDIRECTED",
                                             "HEARD",
                                             "UNPACKED",
                                             "ACCEPTED",
                                             "JOINED"};
    return "STEP_" + std::string(kNames[step]);
}

void expect_clean(const std::vector<std::string>& findings) {
    for (const std::string& finding : findings) {
        ADD_FAILURE() << finding;
    }
}

class Travel : public Realm {
  protected:
    void begin(int count, const std::vector<std::string>& sets = {}) {
        write_config(castle, "meadow", "");
        write_config(meadow, "castle", "");
        for (const std::string& account : accounts(count)) {
            add(account);
        }
        give_tokens(castle, accounts(count));
        start(castle, sets, false);
        start(meadow, sets, false);
        wait_until_ready(castle);
        wait_until_ready(meadow);
    }

    [[nodiscard]] bool all_play() const {
        return std::all_of(
            players.begin(), players.end(), [](const auto& p) { return p->plays(); });
    }

    /// The first login is in the castle, whose store has the tokens.
    void enter_the_castle() {
        const std::uint16_t port = meadow.port;
        meadow.port = 0;
        ASSERT_TRUE(play_until(
            [&] {
                return std::all_of(
                    players.begin(), players.end(), [](const auto& p) { return p->joins > 0; });
            },
            kPatience))
            << castle.server->errors();
        meadow.port = port;
    }

    void end() {
        for (const auto& player : players) {
            player->quit();
        }
        stop(castle);
        stop(meadow);
    }

    /// `all_play` and nothing more to travel: portals stay, so it is a moment.
    void settle() {
        EXPECT_TRUE(play_until([&] { return all_play(); }, kPatience));
    }
};

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
    expect_clean(findings());
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
    expect_clean(findings());
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
    const std::vector<std::string> found = findings();
    ASSERT_FALSE(found.empty());
    EXPECT_NE(found.front().find("is in two worlds"), std::string::npos) << found.front();
}

TEST_F(Travel, TheCheckerSeesWhatGotLost) {
    begin(3, {"testing.travel.lose_records=true"});
    enter_the_castle();
    ASSERT_TRUE(play_until([&] { return travels() >= 3; }, kPatience));
    settle();
    end();
    const std::vector<std::string> found = findings();
    ASSERT_FALSE(found.empty());
    EXPECT_NE(found.front().find("has 0 good tokens"), std::string::npos) << found.front();
}

TEST_F(Travel, KillsAtEachStepLoseAndDoubleNobody) {
    constexpr int kSteps = 11;
    const char* asked = std::getenv("ZONED_TRAVEL_KILLS");
    const int kills = asked != nullptr ? std::atoi(asked) : 22;
    begin(12);
    enter_the_castle();
    std::uint32_t random = 12345;
    int step = 0;
    std::map<int, int> died_at;
    std::map<std::string, int> armed;
    const auto start_armed = [&](World& world) {
        step = step % kSteps + 1;
        random = random * 1664525U + 1013904223U;
        armed[world.name] = step;
        const std::string name = name_of_step(step);
        start(world,
              {"testing.travel.die_at=" + name,
               "testing.travel.die_after=" + std::to_string(1 + (random >> 16U) % 3)},
              false);
    };
    // Servers that run so far die at no step.
    castle.server->signal(SIGKILL);
    meadow.server->signal(SIGKILL);
    castle.server->wait(kPatience);
    meadow.server->wait(kPatience);
    start_armed(castle);
    start_armed(meadow);
    const double begun = now_s();
    int done = 0;
    double last_kill = now_s();
    while (done < kills && now_s() - last_kill < kPatience) {
        play_until([&] { return castle.server->wait(0.0) != -1 || meadow.server->wait(0.0) != -1; },
                   1.0);
        for (World* world : {&castle, &meadow}) {
            if (const int code = world->server->wait(0.0); code != -1) {
                ASSERT_EQ(code, 128 + SIGKILL) << world->server->errors();
                ++done;
                ++died_at[armed[world->name]];
                last_kill = now_s();
                start_armed(*world);
            }
        }
    }
    EXPECT_EQ(done, kills) << castle.server->errors() << meadow.server->errors();
    RecordProperty("seconds", std::to_string(now_s() - begun));
    for (int s = 1; s <= kSteps; ++s) {
        EXPECT_GE(died_at[s], kills / kSteps - 1) << "step " << s;
    }
    for (World* world : {&castle, &meadow}) {
        world->server->signal(SIGKILL);
        world->server->wait(kPatience);
        start(*world);
    }
    settle();
    const std::uint64_t before = travels();
    EXPECT_TRUE(play_until([&] { return travels() > before + 12; }, kPatience))
        << "travel goes on after all that";
    settle();
    end();
    expect_clean(findings());
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
    expect_clean(findings());
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
    EXPECT_NE(report.find("\"verdict\": \"consistent\""), std::string::npos) << report;
    stop(castle);
    stop(meadow);
}

}  // namespace
}  // namespace zoned::testing_cluster
