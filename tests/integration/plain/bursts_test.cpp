// Cosmetic bursts in zones: which players hear of them, how often, and that nothing else changes.
#include "server/app/world/world.h"
#include "tests/integration/plain/plain_log.h"
#include "tests/scenario/small_world.h"
#include "proto/session.pb.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <optional>
#include <set>

namespace zoned::app {
namespace {

const motion::BurstKind kKind{0.5F, 0.5F, 0.0F, 1.0F, 2.0F};

/// Two zones of 120 m side by side, their border at x = 0, with cosmetic sparks.
config::Settings sparkling(float aura_m = 30.0F, float events_per_s = 1000.0F) {
    config::Settings s = scenario::small_world(2, 1, 120.0);
    s.cosmetics.push_back({"smoke", Vec3::Zero(), 0.0F, Vec3::Zero(), {}, {}});
    s.cosmetics.push_back({"sparks", Vec3::Zero(), 0.0F, Vec3::Zero(), {}, kKind});
    s.cosmetic_bursts.push_back({"sparks", 1, kKind, aura_m, events_per_s});
    return s;
}

/// A world with a player at each spawn point, and the burst events of its last tick.
class Sparkling {
  public:
    Sparkling(config::Settings settings, const std::vector<Vec3d>& players) {
        plain_log() = std::make_shared<scenario::PlainLog>();
        settings.spawn_points.clear();
        for (const Vec3d& player : players) {
            settings.spawn_points.push_back({player, "", ""});
        }
        world_.emplace(settings, 1);
        std::vector<mailbox::InboxItem> joins;
        // A client's number chooses its spawn point: as many as it takes until each has one.
        std::vector<ClientId> at(players.size());
        std::size_t missing = players.size();
        for (std::uint32_t n = 1; missing > 0; ++n) {
            const std::size_t point = (n * 7919ULL) % players.size();
            if (!at[point]) {
                at[point] = ClientId(n);
                --missing;
                mailbox::Join join;
                join.client = ClientId(n);
                join.name = "player";
                joins.emplace_back(join);
            }
        }
        clients = at;
        std::vector<mailbox::OutboxItem> out;
        world_->tick(joins, out);
        tick();
    }

    void tick() {
        std::vector<mailbox::OutboxItem> out;
        world_->tick({}, out);
        heard.clear();
        for (const mailbox::OutboxItem& item : out) {
            const auto* event = std::get_if<mailbox::EventOut>(&item);
            if (event != nullptr && event->kind == proto::CORE_EVENT_PARTICLE_BURST) {
                heard.push_back(*event);
            }
        }
    }

    /// In the next tick the zone with that number calls; afterwards no more.
    void tick_with(std::uint16_t zone, const std::function<void(zone::RulesContext&)>& call) {
        plain_log()->each_tick = [&](zone::RulesContext& context) {
            if (context.zone() == ZoneId(zone)) {
                call(context);
            }
        };
        tick();
        plain_log()->each_tick = nullptr;
    }

    [[nodiscard]] World& world() { return *world_; }

    std::vector<ClientId> clients;  ///< by spawn point
    std::vector<mailbox::EventOut> heard;

  private:
    std::optional<World> world_;
};

Vec3 local(const zone::RulesContext& context, const Vec3d& place) {
    return (place - context.origin()).cast<float>();
}

std::vector<ClientId> sorted(std::vector<ClientId> clients) {
    std::sort(clients.begin(), clients.end());
    return clients;
}

TEST(CosmeticBursts, AreToldOnceToThoseWhoHearThePlaceAcrossTheBorderToo) {
    // 5, 25 and 45 m from where it sparks; the first in the other zone. Nimbus 40 m, aura 30 m.
    Sparkling s(sparkling(), {Vec3d(-2.0, 0.9, 0.0), Vec3d(28.0, 0.9, 0.0), Vec3d(48.0, 0.9, 0.0)});
    const Vec3d place(3.0, 1.0, 0.0);
    s.tick_with(2, [&](zone::RulesContext& context) {
        EXPECT_TRUE(context.emit("sparks", local(context, place), Vec3(0.0F, 2.0F, 0.0F), 20));
    });
    ASSERT_EQ(s.heard.size(), 1u);
    EXPECT_EQ(s.heard[0].recipients, sorted({s.clients[0], s.clients[1]}));
    EXPECT_EQ(s.heard[0].tick, s.world().now());
    EXPECT_LE(s.heard[0].payload.size(), 44u);
    proto::ParticleBurst told;
    ASSERT_TRUE(told.ParseFromArray(s.heard[0].payload.data(),
                                    static_cast<int>(s.heard[0].payload.size())));
    EXPECT_EQ(told.system(), 1u);
    EXPECT_EQ(told.count(), 20u);
    // Zone coordinates and back are a rounding of floats at 60 m: 4e-6 m.
    for (int axis = 0; axis < 3; ++axis) {
        EXPECT_NEAR(told.position(axis), place[axis], 1e-5);
    }
    EXPECT_EQ(s.world().bursts_sent(), 1u);
    s.tick();
    EXPECT_TRUE(s.heard.empty()) << "told once";
}

TEST(CosmeticBursts, ThatNobodyHearsAreSentToNobody) {
    Sparkling s(sparkling(), {Vec3d(50.0, 0.9, 0.0)});
    s.tick_with(2, [&](zone::RulesContext& context) {
        EXPECT_TRUE(context.emit(
            "sparks", local(context, Vec3d(19.0, 1.0, 0.0)), Vec3(0.0F, 2.0F, 0.0F), 20));
    });
    EXPECT_TRUE(s.heard.empty()) << "31 m, aura 30 m";
    EXPECT_EQ(s.world().bursts_sent(), 0u);
}

TEST(CosmeticBursts, DifferInTheirSeeds) {
    Sparkling s(sparkling(), {Vec3d(-2.0, 0.9, 0.0), Vec3d(2.0, 0.9, 0.0)});
    std::set<std::uint64_t> seeds;
    std::set<std::uint64_t> ids;
    for (int t = 0; t < 3; ++t) {
        plain_log()->each_tick = [&](zone::RulesContext& context) {
            for (int i = 0; i < 2; ++i) {
                context.emit("sparks", local(context, Vec3d::Zero()), Vec3::UnitX(), 5);
            }
        };
        s.tick();
        for (const mailbox::EventOut& event : s.heard) {
            proto::ParticleBurst told;
            ASSERT_TRUE(
                told.ParseFromArray(event.payload.data(), static_cast<int>(event.payload.size())));
            seeds.insert(told.seed());
            ids.insert(event.event.value);
        }
    }
    plain_log()->each_tick = nullptr;
    EXPECT_EQ(seeds.size(), 12u) << "two zones, three ticks, two bursts in each";
    EXPECT_EQ(ids.size(), 12u);
}

TEST(CosmeticBursts, ThatMakeNoSenseAreRefusedByTheZone) {
    Sparkling s(sparkling(), {Vec3d(2.0, 0.9, 0.0)});
    s.tick_with(2, [&](zone::RulesContext& context) {
        const Vec3 here = local(context, Vec3d(2.0, 1.0, 0.0));
        EXPECT_FALSE(context.emit("smoke", here, Vec3::UnitX(), 5)) << "it has no burst";
        EXPECT_FALSE(context.emit("nobody", here, Vec3::UnitX(), 5));
        EXPECT_FALSE(context.emit("sparks", here, Vec3::UnitX(), 0));
        EXPECT_FALSE(context.emit("sparks", here, Vec3::UnitX(), 1001));
        EXPECT_FALSE(context.emit("sparks", Vec3::Constant(NAN), Vec3::UnitX(), 5));
        EXPECT_FALSE(context.emit("sparks", here, Vec3::Constant(INFINITY), 5));
        EXPECT_FALSE(context.emit("sparks", here, Vec3::Constant(1e30F), 5));
        EXPECT_EQ(context.particles_near("sparks", here, 100.0F), 0u);
    });
    EXPECT_TRUE(s.heard.empty());
}

TEST(CosmeticBursts, AreNoMoreThanTheConfigAllows) {
    // Five a second, 30 ticks each: a second's worth at once, then one every six ticks.
    Sparkling s(sparkling(30.0F, 5.0F), {Vec3d(2.0, 0.9, 0.0)});
    std::vector<std::size_t> told;
    for (int t = 0; t < 90; ++t) {
        s.tick_with(2, [&](zone::RulesContext& context) {
            for (int i = 0; i < 8; ++i) {
                context.emit("sparks", local(context, Vec3d(2.0, 1.0, 0.0)), Vec3::UnitX(), 5);
            }
        });
        told.push_back(s.heard.size());
    }
    EXPECT_EQ(told[0], 5u);
    // The other 89 ticks hold 14 whole shares of six ticks.
    EXPECT_EQ(std::accumulate(told.begin(), told.end(), std::size_t{0}), 5u + 14u);
    EXPECT_EQ(*std::max_element(told.begin() + 1, told.end()), 1u);
}

TEST(CosmeticBursts, ChangeNeitherTheStateNorThePlanNorAnyPass) {
    config::Settings settings = sparkling();
    // Simulated gravel beside them: its seeds must not depend on how many sparks there were.
    zone::ParticleSource gravel;
    gravel.def.name = "gravel";
    gravel.burst = kKind;
    settings.particles.push_back(gravel);
    std::uint64_t hashes[2] = {};
    std::size_t particles[2] = {};
    std::string plans[2];
    for (const int sparks : {0, 1}) {
        Sparkling s(settings, {Vec3d(-2.0, 0.9, 0.0), Vec3d(2.0, 0.9, 0.0)});
        plain_log()->each_tick = [&](zone::RulesContext& context) {
            const Vec3 here = local(context, Vec3d(0.0, 1.0, 0.0));
            for (int i = 0; sparks > 0 && i < 3; ++i) {
                ASSERT_TRUE(context.emit("sparks", here, Vec3::UnitX(), 1000));
            }
            if (context.now() == 10) {
                ASSERT_TRUE(context.emit("gravel", here, Vec3::UnitY(), 7));
            }
        };
        std::size_t events = 0;
        for (int t = 0; t < 40; ++t) {
            s.tick();
            events += s.heard.size();
            for (const auto& zone : s.world().zones()) {
                plans[sparks] += zone->report().plan.runs.to_string() + " ";
                particles[sparks] += zone->report().particles.particles;
                for (const zone::PassReport& pass : zone->report().passes) {
                    plans[sparks] += std::to_string(pass.count) + ",";
                }
            }
        }
        plain_log()->each_tick = nullptr;
        hashes[sparks] = s.world().state_hash();
        EXPECT_EQ(events, sparks > 0 ? 240u : 0u);
    }
    EXPECT_EQ(hashes[0], hashes[1]);
    EXPECT_EQ(plans[0], plans[1]);
    EXPECT_EQ(particles[0], particles[1]);
    EXPECT_GT(particles[0], 0u) << "the gravel";
}

}  // namespace
}  // namespace zoned::app
