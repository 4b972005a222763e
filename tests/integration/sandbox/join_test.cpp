#include "tests/harness/game_test.h"

#include <map>
#include <utility>
#include <vector>

namespace zoned::harness {
namespace {

constexpr double kRoundTripS = 0.1;
constexpr double kNearestM = 30.0;  // of lod[0] in config/minimal.txtpb

class Join : public GameTest {
  protected:
    Join() {
        server.network.delay_s = 0.5 * kRoundTripS;
        bots.bots = 1;
        bots.audit = false;
        bots.freeze = false;
    }

    /// Virtual time from login (Welcome) until the bot has its own state and `wanted` entities
    /// within `radius_m`; below 0: never.
    double playable_after_s(std::size_t wanted, double radius_m) {
        double welcome_s = -1.0;
        double playable_s = -1.0;
        run([&](VirtualServer&, double now_s) {
            if (!swarm || swarm->bots().empty() || playable_s >= 0.0) {
                return;
            }
            const bot::Bot& bot = *swarm->bots().front();
            if (welcome_s < 0.0 && bot.client().state() == link::SessionState::kOnline) {
                welcome_s = now_s;
            }
            if (welcome_s < 0.0 || bot.view() == nullptr || !bot.view()->own().known()) {
                return;
            }
            std::size_t near = 0;
            const Vec3d here = bot.view()->own().position();
            const view::EntityStore& store = bot.view()->store();
            for (const auto& [id, entity] : store.entities()) {
                if (entity.present()) {
                    const Vec3d there =
                        store.predicted(entity.versions.back(), bot.view()->tick()).position;
                    near += (there - here).norm() < radius_m ? 1 : 0;
                }
            }
            if (near >= wanted) {
                playable_s = now_s;
            }
        });
        return playable_s < 0.0 ? -1.0 : playable_s - welcome_s;
    }

    struct Crowded {
        std::size_t nearest = 0;   ///< entities of the nearest level of detail
        std::size_t heard = 0;     ///< of all, at the end
        double playable_s = -1.0;  ///< since Welcome: own state and all of the nearest level
        double bytes_until = 0.0;  ///< down until then, headers counted
        std::size_t out_of_order = 0;
    };

    /// How a bot that stands comes to know a world at rest.
    Crowded join_crowd() {
        bots.mix = {{bot::Script::kIdle, 1.0}};

        struct First {
            double at_s = 0.0;
            double distance_m = 0.0;
        };

        std::map<std::uint32_t, First> firsts;
        std::vector<std::pair<double, double>> bytes;  // until when, how many
        double welcome_s = -1.0;
        double own_s = -1.0;
        Crowded result;
        run([&](VirtualServer&, double now_s) {
            if (!swarm || swarm->bots().empty()) {
                return;
            }
            const bot::Bot& bot = *swarm->bots().front();
            if (welcome_s < 0.0 && bot.client().state() == link::SessionState::kOnline) {
                welcome_s = now_s;
            }
            if (bot.view() == nullptr || !bot.view()->own().known()) {
                return;
            }
            own_s = own_s < 0.0 ? now_s : own_s;
            const link::DatagramStats& d = bot.client().datagrams();
            bytes.emplace_back(now_s, static_cast<double>(d.bytes_in + 28 * d.in));
            const Vec3d here = bot.view()->own().position();
            for (const auto& [id, entity] : bot.view()->store().entities()) {
                if (entity.present() && !firsts.contains(id.value)) {
                    const Vec3d there = bot.view()
                                            ->store()
                                            .predicted(entity.versions.back(), bot.view()->tick())
                                            .position;
                    firsts[id.value] = {now_s, (there - here).norm()};
                }
            }
        });
        result.heard = firsts.size();
        double last_s = own_s;
        double farthest_before_m = 0.0;
        std::map<double, std::pair<double, double>> by_time;  // nearest and farthest shown then
        for (const auto& [id, first] : firsts) {
            const bool nearest = first.distance_m < kNearestM;
            result.nearest += nearest ? 1 : 0;
            last_s = nearest ? std::max(last_s, first.at_s) : last_s;
            auto [at, fresh] = by_time.try_emplace(first.at_s, first.distance_m, first.distance_m);
            at->second.first = std::min(at->second.first, first.distance_m);
            at->second.second = std::max(at->second.second, first.distance_m);
        }
        for (const auto& [at_s, range] : by_time) {
            // Wanderers walk, and the avatar falls a little: a metre is allowed.
            result.out_of_order += range.first < farthest_before_m - 1.0 ? 1 : 0;
            farthest_before_m = std::max(farthest_before_m, range.second);
        }
        for (const auto& [at_s, count] : bytes) {
            result.bytes_until = at_s <= last_s ? count : result.bytes_until;
        }
        result.playable_s = welcome_s < 0.0 || own_s < 0.0 ? -1.0 : last_s - welcome_s;
        return result;
    }
};

TEST_F(Join, IsPlayableWithinTwoRoundTripsOfLogin) {
    bots.seconds = 3.0;
    // 10 crates and 2 wanderers on 100 x 100 m: all are heard.
    const double after_s = playable_after_s(12, 200.0);
    ASSERT_GE(after_s, 0.0);
    EXPECT_LT(after_s, 2.0 * kRoundTripS);
}

TEST_F(Join, IsPlayableWithinTwoRoundTripsAmidFiveThousandEntities) {
    server.sets = {"world.min_x_m=-100",
                   "world.min_z_m=-100",
                   "world.max_x_m=100",
                   "world.max_z_m=100",
                   "scatter[0].count=5000"};
    bots.seconds = 4.0;
    const Crowded seen = join_crowd();
    // The nearest level of detail is a circle of 30 m: 5000 crates on 200 x 200 m are 350 there.
    EXPECT_GT(seen.nearest, 250U);
    EXPECT_GT(seen.heard, 2500U);
    ASSERT_GE(seen.playable_s, 0.0);
    EXPECT_LT(seen.playable_s, 2.0 * kRoundTripS);
    // A window at first and then the budget: nothing beyond it.
    EXPECT_LT(seen.bytes_until, 14600.0 + 16000.0 * 2.0 * kRoundTripS);
    // Nearest first: an entity shown later was not nearer, except for those of one packet's time
    // (the avatar stands; crates rest).
    EXPECT_EQ(seen.out_of_order, 0U);
    RecordProperty("playable_ms", static_cast<int>(1e3 * seen.playable_s));
    RecordProperty("playable_bytes", static_cast<int>(seen.bytes_until));
    RecordProperty("nearest", static_cast<int>(seen.nearest));
}

TEST_F(Join, PredictsItsOwnAvatarToACentimetre) {
    bots.seconds = 30.0;
    bots.bots = 2;
    bots.audit = true;
    bots.mix = {{bot::Script::kWander, 1.0}};
    const auto report = run();
    EXPECT_TRUE(report.consistent) << reasons(report);
    ASSERT_GT(report.own_correction_m.count(), 100U);
    EXPECT_LT(report.own_correction_m.percentile(0.99), 0.01);
}

TEST_F(Join, PredictsItsOwnAvatarToACentimetreOnTheValleysGround) {
    server.config = ZONED_SOURCE_DIR "/config/valley.txtpb";
    bots.seconds = 30.0;
    bots.bots = 4;
    bots.audit = true;
    bots.mix = {{bot::Script::kWander, 1.0}};
    double way_m = 0.0;    // of all avatars
    double climb_m = 0.0;  // up and down
    std::map<std::size_t, Vec3d> last;
    const auto report = run([&](VirtualServer&, double) {
        for (std::size_t i = 0; swarm && i < swarm->bots().size(); ++i) {
            const bot::Bot& one = *swarm->bots()[i];
            if (one.settled_tick() < 0 || !one.view()->own().known()) {
                continue;
            }
            const Vec3d here = one.view()->own().position();
            const auto [at, fresh] = last.try_emplace(i, here);
            way_m += (here - at->second).norm();
            climb_m += std::abs(here.y() - at->second.y());
            at->second = here;
        }
    });
    EXPECT_TRUE(report.consistent) << reasons(report);
    // They do walk, and the ground is no plane.
    EXPECT_GT(way_m, 100.0);
    EXPECT_GT(climb_m, 5.0);
    RecordProperty("way_m", static_cast<int>(way_m));
    RecordProperty("climb_dm", static_cast<int>(10.0 * climb_m));
    ASSERT_GT(report.own_correction_m.count(), 400U);
    EXPECT_LT(report.own_correction_m.percentile(0.99), 0.01);
    RecordProperty("correction_um_p50",
                   static_cast<int>(1e6 * report.own_correction_m.percentile(0.5)));
    RecordProperty("correction_um_p99",
                   static_cast<int>(1e6 * report.own_correction_m.percentile(0.99)));
    RecordProperty("correction_um_max", static_cast<int>(1e6 * report.own_correction_m.max()));
}

}  // namespace
}  // namespace zoned::harness
