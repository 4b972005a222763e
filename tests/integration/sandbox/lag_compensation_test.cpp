// Shots at moving characters: the shooter's own view against the server's decision.
#include "client-sim/view/aim.h"
#include "server/config/settings.h"
#include "tests/harness/capture.h"
#include "tests/harness/game_test.h"
#include "tests/integration/sandbox/shooters_world.h"
#include "proto/sandbox.pb.h"

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <map>
#include <tuple>

namespace zoned::harness {
namespace {

/// A flat world of 60 x 60 m without obstacles, in which no character dies.
constexpr const char* kField = R"(
world { name: "field" seed: 7 min_x_m: -30 min_z_m: -30 max_x_m: 30 max_z_m: 30 }
spawn { x_m: -9 z_m: -9 } spawn { x_m: 9 z_m: -9 } spawn { x_m: -9 z_m: 9 } spawn { x_m: 9 z_m: 9 }
lod { radius_m: 30 position_bound_m: 0.05 orientation_bound_rad: 0.1 }
lod { position_bound_m: 0.5 orientation_bound_rad: 0.3 }
rules { name: "health" value: "10000" }
rules { name: "damage" value: "1" }
rules { name: "shot_cooldown_s" value: "0.05" }
)";

struct Tally {
    std::uint64_t shots = 0;  ///< decided
    std::uint64_t hits = 0;   ///< of these, in the shooter's view
    std::uint64_t agreed = 0;
    std::uint64_t cut = 0;
    std::uint64_t doubted = 0;
    std::uint64_t fired = 0;
    std::uint64_t told_targets = 0;
    double most_rewound_ms = 0.0;
};

class Range : public GameTest {
  protected:
    Range() {
        server.config = std::string(kShootersWorld) + kField;
        server.config_is_text = true;
        bots.bots = 10;
        bots.seconds = seconds();
        bots.mix = *bot::parse_mix("wander:1");
        bots.freeze = false;
    }

    /// ZONED_SHOT_SECONDS makes the long form of it.
    static double seconds() {
        const char* wanted = std::getenv("ZONED_SHOT_SECONDS");
        return wanted != nullptr ? std::atof(wanted) : 8.0;
    }

    void network(double round_trip_s, bool bad) {
        server.network.delay_s = 0.5 * round_trip_s;
        if (bad) {
            server.network.jitter_s = std::min(0.02, 0.5 * round_trip_s);
            server.network.loss = 0.05;
            server.network.duplicate = 0.02;
        }
    }

    /// Bots shoot at, over and past the targets on their screens, evenly over a window that is
    /// twice as wide as a character and half as high again.
    void shoot(std::size_t shooter, bot::Bot& bot) {
        const view::View* view = bot.view();
        if (view == nullptr || bot.settled_tick() < 0 || !view->own().known() ||
            view->tick() < next_[shooter]) {
            return;
        }
        std::vector<Vec3d> targets;
        for (const auto& [id, entity] : view->store().entities()) {
            const auto shown = view->on_screen(entity);
            if (id != view->own().id() && shown) {
                targets.push_back(shown->position);
            }
        }
        if (targets.empty()) {
            return;
        }
        next_[shooter] = view->tick() + 3;
        const Vec3d eye = view::own_eye(*view);
        const Vec3d to = targets[rng_.below(static_cast<std::uint32_t>(targets.size()))] - eye;
        const Vec3d side = Vec3d(to.z(), 0.0, -to.x()).normalized();
        const Vec3d aimed = to + side * static_cast<double>(rng_.range(-0.8F, 0.8F)) +
                            Vec3d(0.0, static_cast<double>(rng_.range(-0.9F, 1.4F)), 0.0);
        std::string payload;
        const EntityId hit = bot::shoot_as_seen(*view, aimed.cast<float>(), payload);
        seen_[{view->own().id().value, view->own().newest_tick()}] = hit;
        bot.command(sandbox::COMMAND_SHOOT, payload);
        ++tally_.fired;
    }

    /// The outcomes that both sides heard of.
    void judge_all() {
        std::map<EntityId, ClientId> client_of;
        for (std::size_t i = 0; i < captures_.size(); ++i) {
            client_of[swarm->bots()[i]->avatar()] = captures_[i]->client;
        }
        for (const auto& capture : captures_) {
            for (const CapturedEvent& event : capture->events) {
                sandbox::Shot shot;
                if (event.kind != sandbox::EVENT_SHOT || !shot.ParseFromString(event.payload)) {
                    continue;
                }
                if (client_of[EntityId(shot.shooter())] == capture->client) {
                    judge(shot);
                } else {
                    ++tally_.told_targets;
                }
            }
        }
    }

    void judge(const sandbox::Shot& shot) {
        const auto seen = seen_.find({shot.shooter(), shot.tick()});
        ASSERT_NE(seen, seen_.end()) << "decided once, and only what was fired";
        ++tally_.shots;
        tally_.hits += seen->second ? 1 : 0;
        tally_.agreed += seen->second.value == shot.hit() ? 1 : 0;
        tally_.cut += shot.cut() ? 1 : 0;
        tally_.doubted += shot.doubted() ? 1 : 0;
        tally_.most_rewound_ms =
            std::max(tally_.most_rewound_ms, static_cast<double>(shot.rewound_ms()));
        seen_.erase(seen);
    }

    Tally play() {
        world = std::make_unique<VirtualServer>(server);
        bots.path_spread_s = server.network.spread_s();
        swarm = std::make_unique<app::Swarm>(bots, [this](std::size_t) {
            captures_.push_back(std::make_shared<Capture>());
            captures_.back()->quantization = world->settings().replication.quantization;
            captures_.back()->upright = {true};
            return capture_transport(world->connect(), captures_.back());
        });
        while (!swarm->done() && world->now_s() < bots.seconds + 60.0) {
            world->step();
            for (const auto& capture : captures_) {
                capture->now_s = world->client_time_s();
            }
            swarm->advance(world->client_time_s());
            if (swarm->progress(world->client_time_s()).seconds_left > 1.0) {
                for (std::size_t i = 0; i < swarm->bots().size(); ++i) {
                    if (swarm->bots()[i]) {
                        shoot(i, *swarm->bots()[i]);
                    }
                }
            }
        }
        judge_all();
        return tally_;
    }

  private:
    std::vector<std::shared_ptr<Capture>> captures_;
    core::Rng rng_{5, 0};
    std::map<std::size_t, Tick> next_;
    std::map<std::pair<std::uint32_t, Tick>, EntityId> seen_;
    Tally tally_;
};

class Agreement : public Range,
                  public testing::WithParamInterface<std::tuple<view::ViewKind, int, bool>> {};

INSTANTIATE_TEST_SUITE_P(
    Networks,
    Agreement,
    testing::Combine(testing::Values(view::ViewKind::kExtrapolate, view::ViewKind::kInterpolate),
                     testing::Values(0, 100, 200),
                     testing::Bool()),
    [](const auto& instance) {
        return std::string(std::get<0>(instance.param) == view::ViewKind::kExtrapolate
                               ? "Extrapolating"
                               : "Interpolating") +
               std::to_string(std::get<1>(instance.param)) + "ms" +
               (std::get<2>(instance.param) ? "Bad" : "Good");
    });

/// 99.9 % is the promise. In N shots the number of disagreements at exactly that rate is about
/// Poisson with mean N / 1000. Chance never reaches five standard deviations above it.
TEST_P(Agreement, BetweenServerAndShooterIn999Of1000Shots) {
    bots.view = std::get<0>(GetParam());
    network(1e-3 * std::get<1>(GetParam()), std::get<2>(GetParam()));
    const Tally tally = play();
    const double shots = static_cast<double>(tally.shots);
    const auto wrong = static_cast<double>(tally.shots - tally.agreed);
    std::printf(
        "%llu fired, %llu decided, %llu hits seen, agreed %.4f %%, cut %llu, doubted %llu, at most "
        "%.0f ms\n",
        static_cast<unsigned long long>(tally.fired),
        static_cast<unsigned long long>(tally.shots),
        static_cast<unsigned long long>(tally.hits),
        100.0 * static_cast<double>(tally.agreed) / shots,
        static_cast<unsigned long long>(tally.cut),
        static_cast<unsigned long long>(tally.doubted),
        tally.most_rewound_ms);
    EXPECT_GT(tally.shots, 400u);
    EXPECT_GT(tally.hits, tally.shots / 5) << "the window is about a character";
    EXPECT_LT(tally.hits, tally.shots * 4 / 5);
    EXPECT_GT(tally.told_targets, tally.hits / 2) << "both sides hear of it";
    EXPECT_LE(wrong, 1e-3 * shots + 5.0 * std::sqrt(1e-3 * shots));
}

/// The checker is checked: without rewinding, views of others' past do not agree.
TEST_F(Range, DisagreesWithoutRewinding) {
    network(0.2, false);
    server.sets = {"rewind.most_ms=0", "rewind.slack_m=0"};
    bots.view = view::ViewKind::kInterpolate;
    const Tally tally = play();
    EXPECT_GT(tally.shots, 400u);
    EXPECT_GT(tally.shots - tally.agreed, tally.shots / 20);
    EXPECT_GT(tally.cut, tally.shots / 2) << "and the shooter is told that the bound cut it";
}

}  // namespace
}  // namespace zoned::harness
