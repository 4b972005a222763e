// Shared clocks and shared variables in zones: rules read them and change them ahead, and clients
// receive them.
#include "server/app/world/world.h"
#include "tests/integration/plain/plain_log.h"
#include "tests/scenario/small_world.h"
#include "proto/session.pb.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <map>
#include <optional>

namespace zoned::app {
namespace {

/// Two zones with a clock of 24 hours, half an hour per second, and two kinds of weather.
config::Settings with_weather() {
    config::Settings s = scenario::small_world(2, 1, 120.0);
    s.environment.clocks.push_back({"time_of_day", 24.0, {0, 8.0, 0.5}});
    clock::SharedVariableDef rain{"rain", 5, 1.0, {}};
    rain.phases = {{"clear", 0.0, 1.0, 2.0, 4.0}, {"storm", 1.0, 1.0, 1.0, 2.0}};
    s.environment.variables.push_back(rain);
    return s;
}

class Weathered {
  public:
    explicit Weathered(const config::Settings& settings) {
        plain_log() = std::make_shared<scenario::PlainLog>();
        world.emplace(settings, 1);
    }

    /// Returns the payloads sent to any client in this tick.
    std::vector<proto::SharedEnvironment> tick(const std::vector<mailbox::InboxItem>& items = {}) {
        std::vector<mailbox::OutboxItem> out;
        world->tick(items, out);
        std::vector<proto::SharedEnvironment> told;
        for (const mailbox::OutboxItem& item : out) {
            const auto* event = std::get_if<mailbox::EventOut>(&item);
            if (event != nullptr && event->kind == proto::CORE_EVENT_SHARED_ENVIRONMENT) {
                EXPECT_TRUE(told.emplace_back().ParseFromArray(
                    event->payload.data(), static_cast<int>(event->payload.size())));
                largest_payload = std::max(largest_payload, event->payload.size());
            }
        }
        return told;
    }

    static mailbox::Join player(std::uint32_t client = 1) {
        mailbox::Join join;
        join.client = ClientId(client);
        join.name = "player";
        return join;
    }

    std::optional<World> world;
    std::size_t largest_payload = 0;
};

TEST(SharedEnvironment, ShowsTheSameInAllZonesAndToTheRules) {
    // One player in either zone: rules of empty zones need not run.
    config::Settings settings = with_weather();
    settings.spawn_points = {{Vec3d(-20.0, 0.9, 0.0), "", ""}, {Vec3d(20.0, 0.9, 0.0), "", ""}};
    Weathered w(settings);
    std::map<Tick, std::vector<double>> seen;
    plain_log()->each_tick = [&](zone::RulesContext& context) {
        seen[context.now()].push_back(*context.shared_value("time_of_day"));
        seen[context.now()].push_back(*context.shared_value("rain"));
        EXPECT_EQ(context.shared_value("moon"), std::nullopt);
    };
    w.tick({Weathered::player(1), Weathered::player(2)});
    for (int i = 0; i < 300; ++i) {
        w.tick();
    }
    bool rained = false;
    int both = 0;
    for (const auto& [tick, values] : seen) {
        const double hours = 8.0 + 0.5 * static_cast<double>(tick) / 30.0;
        EXPECT_NEAR(values[0], std::fmod(hours, 24.0), 1e-9);
        rained = rained || values[1] == 1.0;
        if (values.size() == 4) {
            ++both;
            EXPECT_EQ(values[0], values[2]);
            EXPECT_EQ(values[1], values[3]);
        }
    }
    EXPECT_TRUE(rained);
    EXPECT_GT(both, 100);
}

TEST(SharedEnvironment, IsToldAtLoginAndOnceAMinuteInFewBytes) {
    Weathered w(with_weather());
    EXPECT_EQ(w.tick({Weathered::player()}).size(), 1U) << "at login";
    std::size_t told = 0;
    for (int i = 0; i < 5400; ++i) {
        told += w.tick().size();
    }
    EXPECT_EQ(told, 3U) << "three minutes";
    // Two doubles and a tick for the clock, a double and three numbers for the weather, keys.
    EXPECT_LE(w.largest_payload, 55U);
}

TEST(SharedEnvironment, IsChangedByRulesAheadOfTimeSoThatAClientThatWasToldComputesTheSame) {
    const config::Settings settings = with_weather();
    Weathered w(settings);
    clock::SharedEnvironment client(settings.environment, 1.0 / 30.0);
    const auto take = [&](const std::vector<proto::SharedEnvironment>& told) {
        for (const proto::SharedEnvironment& one : told) {
            for (const auto& c : one.courses()) {
                client.announce(c.clock(), {c.from(), c.value(), c.rate_per_s()});
            }
            for (const auto& c : one.cursors()) {
                client.place(c.variable(), {c.number(), c.since(), c.phase(), c.before()});
            }
        }
        return told.size();
    };
    take(w.tick({Weathered::player()}));
    const auto in_step = [&] {
        const Tick now = w.world->now();
        const clock::SharedEnvironment& truth = *w.world->zones()[0]->state().settings.environment;
        return client.clock_at(0, now) == truth.clock_at(0, now) &&
               client.value_at(0, now) == truth.value_at(0, now) &&
               client.clock_at(0, now).has_value();
    };
    Tick changed = 0;
    plain_log()->each_tick = [&](zone::RulesContext& context) {
        if (context.now() == 20 && changed == 0) {
            changed = context.now();
            EXPECT_TRUE(context.set_clock_rate("time_of_day", 3.0, 1.0));
            EXPECT_FALSE(context.set_clock_rate("moon", 3.0, 1.0));
            EXPECT_FALSE(context.set_clock_rate(
                "time_of_day", std::numeric_limits<double>::quiet_NaN(), 1.0));
            EXPECT_FALSE(context.set_clock_rate("time_of_day", 1.0, -1.0));
        }
    };
    std::size_t told = 0;
    double at_change = 0.0;
    for (int i = 0; i < 200; ++i) {
        const auto news = w.tick();
        told += news.size();
        // Announcements come late at times, and still in time.
        take(news);
        EXPECT_TRUE(in_step()) << w.world->now();
        if (w.world->now() == 50) {
            at_change = *client.clock_at(0, 50);
        }
    }
    EXPECT_EQ(changed, 20);
    EXPECT_EQ(told, 1U);
    EXPECT_NEAR(at_change, 8.0 + 0.5 * 50.0 / 30.0, 1e-9) << "the old rate up to then";
    EXPECT_NEAR(*client.clock_at(0, 80), std::fmod(at_change + 3.0, 24.0), 1e-9);
}

}  // namespace
}  // namespace zoned::app
