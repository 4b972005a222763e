// Servers and leaders of the board are killed again and again while players travel: nobody is lost,
// doubled or in two worlds.
#include "tests/integration/cluster/realm.h"

#include <algorithm>
#include <array>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <map>

namespace zoned::testing_cluster {
namespace {

/// As testing.proto names the steps, in its order.
constexpr std::array kSteps{"WISHED",
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

/// A number from the environment, by which the long targets ask for more.
int asked(const char* name, int otherwise) {
    const char* text = std::getenv(name);
    return text != nullptr ? std::atoi(text) : otherwise;
}

double percentile(std::vector<double> values, double share) {
    if (values.empty()) {
        return 0.0;
    }
    std::sort(values.begin(), values.end());
    const auto at = static_cast<std::size_t>(share * static_cast<double>(values.size()));
    return values[std::min(at, values.size() - 1)];
}

class Kills : public Realm {
  protected:
    /// It dies when it comes to that step for this time.
    void start_armed(World& world, std::size_t step, std::uint32_t after) {
        armed_[world.name] = step;
        start(world,
              {"testing.travel.die_at=STEP_" + std::string(kSteps.at(step)),
               "testing.travel.die_after=" + std::to_string(after)},
              false);
    }

    /// The step with the fewest deaths, with the one that the other server is about to die at.
    std::size_t next_step(const World& world) const {
        std::array<int, kSteps.size()> planned = kills_;
        for (const auto& [name, step] : armed_) {
            planned.at(step) += name != world.name ? 1 : 0;
        }
        return static_cast<std::size_t>(std::min_element(planned.begin(), planned.end()) -
                                        planned.begin());
    }

    /// Plays until enough servers died at the steps that they are armed for. `again` starts one.
    void count_deaths(const std::function<bool()>& enough,
                      const std::function<void(World&)>& again) {
        double last_s = now_s();
        while (!enough() && now_s() - last_s < kPatience) {
            play_until([&] { return ended(castle) || ended(meadow); }, 1.0);
            for (World* world : {&castle, &meadow}) {
                if (!ended(*world)) {
                    continue;
                }
                ASSERT_EQ(world->server->wait(0.0), 128 + SIGKILL) << world->server->errors();
                ++kills_.at(armed_.at(world->name));
                last_s = now_s();
                again(*world);
            }
        }
        EXPECT_TRUE(enough()) << castle.server->errors() << meadow.server->errors();
    }

    /// Both, at a moment like any other.
    void kill_servers() {
        for (World* world : {&castle, &meadow}) {
            world->server->signal(SIGKILL);
            world->server->wait(kPatience);
        }
    }

    /// Both have died, and what they kept of their worlds is gone.
    void begin_anew() {
        kill_servers();
        for (const World* world : {&castle, &meadow}) {
            std::filesystem::remove_all(world->state + "/journal");
        }
    }

    static bool ended(const World& world) { return world.server->wait(0.0) != -1; }

    /// Prints the result of the run. Each finding is a failure.
    void report(const char* name, int leaders) {
        std::map<TravelFinding::Wrong, int> count;
        for (const TravelFinding& finding : findings()) {
            ADD_FAILURE() << finding.text;
            ++count[finding.wrong];
        }
        std::vector<double> gaps;
        for (const auto& player : players) {
            gaps.insert(gaps.end(), player->gaps_s.begin(), player->gaps_s.end());
        }
        int sum = 0;
        std::printf("%s\n", name);
        for (std::size_t step = 0; step < kSteps.size(); ++step) {
            sum += kills_.at(step);
            if (kills_.at(step) > 0) {
                std::printf("  killed at %-12s %6d\n", kSteps.at(step), kills_.at(step));
            }
        }
        std::printf("  servers killed          %6d\n  leaders killed          %6d\n", sum, leaders);
        std::printf("  travels                 %6llu\n",
                    static_cast<unsigned long long>(travels()));
        std::printf("  sessions that came back %6llu\n",
                    static_cast<unsigned long long>(recovered()));
        using Wrong = TravelFinding::Wrong;
        std::printf("  lost %d, doubled %d, moments with two owners %d\n",
                    count[Wrong::kLost],
                    count[Wrong::kDoubled],
                    count[Wrong::kTwoOwners]);
        std::printf(
            "  without an avatar: p50 %.0f ms, p99 %.0f ms, longest %.0f ms, of %zu times\n",
            1e3 * percentile(gaps, 0.5),
            1e3 * percentile(gaps, 0.99),
            1e3 * percentile(gaps, 1.0),
            gaps.size());
    }

    /// By what the server said when its world came back, if it did.
    static void expect_whole(const World& world) {
        const std::string log = world.server->errors();
        EXPECT_EQ(log.find("not all is as it was"), std::string::npos) << log;
        EXPECT_TRUE(log.find("in the world as it was") == std::string::npos ||
                    log.find(" 0 are in another one") != std::string::npos)
            << "nobody is given away whose leaving a crash would undo: " << log;
    }

    void travel_on() {
        settle();
        const std::uint64_t before = travels();
        EXPECT_TRUE(play_until([&] { return travels() > before + 12; }, kPatience))
            << "travel goes on after all that";
        settle();
        end();
    }

    std::array<int, kSteps.size()> kills_{};  // of servers at a step that they were armed for
    std::map<std::string, std::size_t> armed_;
};

TEST_F(Kills, AtEachStepLoseAndDoubleNobody) {
    const int wanted = asked("ZONED_TRAVEL_KILLS", 11) / static_cast<int>(kSteps.size());
    begin(12);
    enter_the_castle();
    std::uint32_t random = 12345;
    const auto arm = [&](World& world) {
        random = random * 1664525U + 1013904223U;
        start_armed(world, next_step(world), 1 + (random >> 16U) % 3);
    };
    // Servers that run so far die at no step.
    kill_servers();
    arm(castle);
    arm(meadow);
    count_deaths(
        [&] {
            return std::all_of(
                kills_.begin(), kills_.end(), [&](int deaths) { return deaths >= wanted; });
        },
        arm);
    kill_servers();
    start(castle);
    start(meadow);
    travel_on();
    report("kills at each step", 0);
}

TEST_F(Kills, AtEachStepOfWorldsThatComeBackLoseAndDoubleNobody) {
    const int wanted = asked("ZONED_RECOVERY_KILLS", 11) / static_cast<int>(kSteps.size());
    recovers = true;
    begin(12);
    enter_the_castle();
    for (std::size_t step = 0; step < kSteps.size(); ++step) {
        // A world comes back under its very config, with the step that it is armed for. With
        // another step it begins anew.
        begin_anew();
        start_armed(castle, step, 3);
        start_armed(meadow, step, 3);
        count_deaths([&] { return kills_.at(step) >= wanted; },
                     [&](World& world) {
                         expect_whole(world);
                         start_armed(world, step, 3);
                     });
        play_until([&] { return all_play() || ended(castle) || ended(meadow); }, kPatience);
        expect_whole(castle);
        expect_whole(meadow);
    }
    begin_anew();
    start(castle);
    start(meadow);
    travel_on();
    EXPECT_GT(recovered(), 0U);
    report("kills at each step of worlds that come back", 0);
}

class LeaderKills : public Kills {
  protected:
    void SetUp() override {
        Realm::SetUp();
        // Three in one group, in place of the one.
        std::array<std::uint16_t, 3> ports{};
        std::string routes;
        for (std::uint16_t& port : ports) {
            port = test::free_port();
            routes += (routes.empty() ? "" : ",") + std::string("nats://127.0.0.1:") +
                      std::to_string(port);
        }
        const auto member = [&](std::size_t i) {
            return std::make_unique<test::NatsServer>(
                std::vector<std::string>{"--server_name",
                                         "n" + std::to_string(i),
                                         "--cluster_name",
                                         "realm",
                                         "--cluster",
                                         "nats://127.0.0.1:" + std::to_string(ports.at(i)),
                                         "--routes",
                                         routes});
        };
        nats = member(0);
        more_nats.push_back(member(1));
        more_nats.push_back(member(2));
        cluster_lines = "lease_s: 12 replicas: 3";
    }

    /// The server that last said it leads the board; null: none did yet.
    test::NatsServer* leader() {
        static constexpr const char* kLeads = "JetStream cluster new stream leader for";
        test::NatsServer* out = nullptr;
        std::string newest;
        for (test::NatsServer* one : {nats.get(), more_nats[0].get(), more_nats[1].get()}) {
            const std::string log = one->log();
            const std::size_t at = log.rfind(kLeads);
            if (at == std::string::npos) {
                continue;
            }
            // [pid] date time [INF] text
            const std::size_t line = log.rfind('\n', at) + 1;
            const std::string when = log.substr(log.find(']', line), at - log.find(']', line));
            if (when > newest) {
                newest = when;
                out = one;
            }
        }
        return out;
    }
};

TEST_F(LeaderKills, LoseAndDoubleNobody) {
    const int kills = asked("ZONED_LEADER_KILLS", 1);
    portal_wait_s = 1.0;
    begin(6);
    enter_the_castle();
    for (int i = 0; i < kills; ++i) {
        const std::uint64_t before = travels();
        ASSERT_TRUE(play_until([&] { return travels() > before + 6; }, kPatience))
            << castle.server->errors() << meadow.server->errors();
        test::NatsServer* victim = leader();
        ASSERT_NE(victim, nullptr) << nats->log();
        victim->kill();
        const std::uint64_t then = travels();
        EXPECT_TRUE(play_until([&] { return travels() > then + 12; }, kPatience))
            << "two of three are enough";
        victim->start();
    }
    travel_on();
    report("kills of the leader of three NATS servers", kills);
}

}  // namespace
}  // namespace zoned::testing_cluster
