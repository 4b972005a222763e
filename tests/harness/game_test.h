// GameTest: a GoogleTest fixture with server, bots and a bad network in one process. Time is
// virtual.
//
// A studio's netcode test in a few lines (link the test with your own rules):
//
//   #include "tests/harness/game_test.h"
//
//   TEST_F(GameTest, StaysConsistentOnABadNetwork) {
//       server.config = "my_world.txtpb";  // beside this source
//       server.network.loss = 0.05;
//       server.network.delay_s = 0.06;
//       bots.bots = 20;
//       bots.seconds = 10;
//       const auto report = run();
//       EXPECT_TRUE(report.consistent) << reasons(report);
//       EXPECT_EQ(report.events_lost, 0u);
//   }
//
// A test that plays itself steers the first bots, and time goes on where it waits:
//
//   TEST_F(GameTest, ALeverOpensTheGate) {
//       auto& ann = steer();
//       begin();
//       ann.walk_to(3.0, 8.0);
//       ASSERT_TRUE(play_until([&] { return ann.arrived(); }, 10.0));
//       ann.command(kPull);
//       EXPECT_TRUE(play_until([&] { return ann.heard(kOpened) > 0; }, 2.0));
//       EXPECT_TRUE(finish().consistent);
//   }
#pragma once

#include "client-sim/app/swarm.h"
#include "tests/harness/side_effects.h"
#include "tests/harness/steered_player.h"
#include "tests/harness/virtual_server.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <functional>
#include <memory>
#include <source_location>
#include <string>
#include <utility>
#include <vector>

namespace zoned::harness {

class GameTest : public ::testing::Test {
  protected:
    GameTest() {
        server.config = ZONED_WORLDS_DIR "/minimal.txtpb";
        bots.bots = 8;
        bots.seconds = 5.0;
        // Changes the course of everything: a check that passes for one seed must pass for all.
        if (const char* seed = std::getenv("ZONED_SEED")) {
            bots.seed = std::strtoull(seed, nullptr, 10);
            server.network.seed = bots.seed;
        }
    }

    /// Runs the swarm to its verdict. `each_step` may interfere (cut streams, look into the world,
    /// ...); it gets the virtual time in seconds. Gives up, and fails the test, after ten virtual
    /// minutes beyond the run. A relative path of the config counts from the folder of the calling
    /// source file, wherever the test is started.
    measure::RunReport run(const std::function<void(VirtualServer&, double)>& each_step = {},
                           const std::source_location& caller = std::source_location::current()) {
        set_up(caller.file_name());
        play_to_the_end(bots.seconds, each_step);
        return swarm->report();
    }

    /// One more of the first bots that the test steers. Its team is the next of `bots.teams`. Call
    /// it before begin(), which makes as many bots as are steered at least.
    SteeredPlayer& steer() {
        steered_.push_back(std::make_unique<SteeredPlayer>());
        return *steered_.back();
    }

    /// Begins a game that goes on until finish(), and plays until everybody has joined; fails the
    /// test where somebody does not. `bots.seconds` counts for nothing.
    void begin(const std::source_location& caller = std::source_location::current()) {
        bots.bots = std::max(bots.bots, steered_.size());
        bots.seconds = 1e9;
        bots.make_own_script = [this, others = bots.make_own_script](std::size_t index,
                                                                     const std::string& team) {
            return index < steered_.size() ? steered_[index]->script()
                   : others                ? others(index, team)
                                           : nullptr;
        };
        set_up(caller.file_name());
        for (std::size_t i = 0; i < steered_.size(); ++i) {
            steered_[i]->play_as(swarm->bots()[i].get());
        }
        EXPECT_TRUE(
            play_until([this] { return swarm->phase() == app::Swarm::RunPhase::kRun; }, 60.0))
            << "the game does not begin";
        for (const auto& player : steered_) {
            EXPECT_TRUE(play_until([&] { return player->joined(); }, 10.0))
                << "a steered player does not join: " << swarm->unreachable();
        }
        begun_s_ = world->now_s();
    }

    /// Virtual time goes on until something holds: true, or false after `at_most_s`.
    bool play_until(const std::function<bool()>& holds, double at_most_s) {
        const double end_s = world->now_s() + at_most_s;
        while (!holds()) {
            if (world->now_s() >= end_s) {
                return false;
            }
            step();
        }
        return true;
    }

    void play(double seconds) {
        play_until([] { return false; }, seconds);
    }

    /// Ends the game, and gives the verdict on all bots, those that are steered among them. A short
    /// game goes on until each of them was compared with the truth.
    measure::RunReport finish() {
        play(std::max(0.0, begun_s_ + 2.0 * bots.audit_every_s + 0.5 - world->now_s()));
        swarm->end_run(world->client_time_s());
        play_to_the_end(world->now_s());
        return swarm->report();
    }

    /// Plays the game twice, the second time with two threads. Names the first tick after which a
    /// zone is not the same, and each function by which the rules asked for something that is not
    /// the zone's: a clock, a file, a random number, a socket (SideEffects). Empty: neither. What
    /// no function tells shows in the tick alone: an address, an unordered map, what another run
    /// left.
    std::string difference_between_runs(
        const std::source_location& caller = std::source_location::current()) {
        std::vector<std::vector<std::uint64_t>> hashes;  // of zones, by tick
        std::string difference;
        const auto compare = [&](VirtualServer& now, bool again) {
            std::vector<std::uint64_t> zones;
            const auto tick = static_cast<std::size_t>(now.simulated());
            now.hash_zones(zones);
            if (!again) {
                hashes.resize(std::max(hashes.size(), tick + 1));
                hashes[tick] = zones;
            } else if (difference.empty() && (tick >= hashes.size() || hashes[tick] != zones)) {
                difference = "after tick " + std::to_string(tick) +
                             " the game is not the same in a second run";
            }
        };
        effects_ = std::make_unique<SideEffects>();
        for (const bool again : {false, true}) {
            Tick last = 0;
            server.threads = again ? 2 : 1;
            run(
                [&](VirtualServer& now, double) {
                    if (now.simulated() != last) {
                        last = now.simulated();
                        compare(now, again);
                    }
                },
                caller);
        }
        if (const std::string called = effects_->text(); !called.empty()) {
            difference += (difference.empty() ? "" : "; ") + called;
        }
        return difference;
    }

    void set_up(const char* caller) {
        find_config(caller);
        swarm.reset();  // its transports lead to the world before
        world = std::make_unique<VirtualServer>(server);
        if (wrap_rules) {
            world->wrap_rules(wrap_rules);
        }
        if (effects_) {
            effects_->watch(*world);
        }
        bots.path_spread_s = server.network.spread_s();
        swarm = std::make_unique<app::Swarm>(bots, [this](std::size_t) {
            auto transport = world->connect();
            return wrap ? wrap(std::move(transport)) : std::move(transport);
        });
    }

    void step(const std::function<void(VirtualServer&, double)>& each_step = {}) {
        world->step();
        if (each_step) {
            each_step(*world, world->now_s());
        }
        if (!clients_stall(world->now_s())) {
            swarm->advance(world->client_time_s());
        }
    }

    /// The run is over at about `end_s`.
    void play_to_the_end(double end_s,
                         const std::function<void(VirtualServer&, double)>& each_step = {}) {
        while (!swarm->done()) {
            step(each_step);
            if (world->now_s() > end_s + 600.0) {
                ADD_FAILURE() << "the swarm does not come to its end";
                break;
            }
        }
    }

    void find_config(const std::filesystem::path& source) {
        const std::filesystem::path config = source.parent_path() / server.config;
        if (!server.config_is_text && std::filesystem::exists(config)) {
            server.config = config.string();
        }
    }

    [[nodiscard]] bool clients_stall(double now_s) const {
        return std::any_of(client_stalls.begin(), client_stalls.end(), [&](const Span& s) {
            return now_s >= s.from_s && now_s < s.until_s;
        });
    }

    static std::string reasons(const measure::RunReport& report) {
        std::string text;
        for (const std::string& reason : report.reasons) {
            text += reason + "\n";
        }
        return text;
    }

    /// True when some reason of the verdict contains `word`.
    static bool has_reason(const measure::RunReport& report, const std::string& word) {
        return reasons(report).find(word) != std::string::npos;
    }

    /// Puts other rules around those of each zone; empty: nothing.
    WrapRules wrap_rules;
    VirtualServerSettings server;     ///< config, overrides, network
    app::SwarmSettings bots;          ///< their number, duration and behaviour
    std::vector<Span> client_stalls;  ///< the machine under the bots is starved
    /// Wraps the transport between a bot and its path to the server; empty: nothing.
    std::function<std::unique_ptr<link::Transport>(std::unique_ptr<link::Transport>)> wrap;
    std::unique_ptr<SideEffects> effects_;  ///< outlives the world, whose rules note them there
    std::unique_ptr<VirtualServer> world;
    std::vector<std::unique_ptr<SteeredPlayer>> steered_;  // outlive the swarm's scripts
    double begun_s_ = 0.0;
    std::unique_ptr<app::Swarm> swarm;
};

}  // namespace zoned::harness

using zoned::harness::GameTest;
