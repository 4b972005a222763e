// Herds in zones: off-screen herds cross borders and pass walls as simulated ones do.
#include "tests/integration/plain/crowd_world.h"

#include <array>
#include <cmath>

namespace zoned::app {
namespace {

using test::Crowd;
using test::with;

/// Sheep that go round three places on either side of a border, past a house.
std::string pastures(int seed, int count) {
    std::string text = R"(
world { name: "pastures" seed: 5 tick_rate_hz: 20 min_x_m: -200 min_z_m: -200 max_x_m: 200 max_z_m: 200 }
zones { zone_grid { columns: 2 rows: 1 } ghost_margin_m: 60 }
replication { silence_ticks: 10 }
ai { suspend_offscreen: false }
point_of_interest { name: "brook" x_m: -60 z_m: 0 radius_m: 1 }
point_of_interest { name: "oaks" x_m: 60 z_m: -40 radius_m: 1 }
point_of_interest { name: "hill" x_m: 60 z_m: 40 radius_m: 1 }
type { name: "player" kind: CHARACTER capsule { radius_m: 0.4 length_m: 1 } aura_m { normal: 50 } nimbus_m { normal: 50 } character { } }
type { name: "sheep" kind: CHARACTER capsule { radius_m: 0.4 length_m: 0.3 } aura_m { normal: 30 } character { speed_mps: 3 } brain: "graze" }
brain { name: "graze" state { name: "drift" action: FLOCK speed_factor: 0.5 radius_m: 12 along: "brook" along: "oaks" along: "hill" } }
statics { box { x_m: 30 y_m: 2 z_m: -30 size { x_m: 8 y_m: 4 z_m: 8 } } }
spawn { x_m: 0 z_m: 190 }
lod { position_bound_m: 0.5 orientation_bound_rad: 0.3 }
session { dev_mode_loopback: true }
)";
    return text + "scatter { type: \"sheep\" count: " + std::to_string(count) +
           " seed: " + std::to_string(seed) +
           " min_distance_m: 0.9 region { min_x_m: -75 max_x_m: -45 min_z_m: -15 max_z_m: 15 } }\n";
}

struct Place {
    Vec2 at = Vec2::Zero();
    std::size_t count = 0;
    std::size_t active = 0;
};

/// The centre of all sheep, world coordinates.
Place centre_of(Crowd& crowd) {
    Place place;
    for (const auto& zone : crowd.world().zones()) {
        const zone::ZoneState& state = zone->state();
        const Vec3d origin = state.settings.region().origin();
        for (std::size_t n = 0; n < state.agents.size(); ++n) {
            const ai::Agent& agent = state.agents.at(state.agents.nth(n));
            const Vec3& body = state.entities.position[state.entities.find(agent.entity)];
            const Vec2 at =
                ai::whereabouts(agent, Vec2(body.x(), body.z()), state.now + 1, state.settings.dt);
            place.at += at + Vec2(static_cast<float>(origin.x()), static_cast<float>(origin.z()));
            ++place.count;
        }
        place.active += state.agents.active().size();
    }
    place.at /= static_cast<float>(place.count);
    return place;
}

/// Turns of the herd's centre about the middle of its round trip, in half a minute more than it
/// needs for one.
double turns_of(int seed, bool unseen) {
    Crowd crowd(
        unseen ? with(pastures(seed, 24), "suspend_offscreen: false", "suspend_offscreen: true")
               : pastures(seed, 24));
    const Vec2 middle(20.0F, 0.0F);
    double turned = 0.0;
    double before = std::atan2(0.0, -80.0);
    std::size_t suspended = 0;
    for (int second = 0; second < 300; ++second) {
        for (int t = 0; t < 20; ++t) {
            crowd.tick();
        }
        const Place place = centre_of(crowd);
        EXPECT_EQ(place.count, 24U) << "after " << second << " s";
        suspended += place.count - place.active;
        const Vec2 out = place.at - middle;
        const double now = std::atan2(static_cast<double>(out.y()), static_cast<double>(out.x()));
        turned += std::remainder(now - before, 2.0 * M_PI);
        before = now;
        EXPECT_LT(crowd.in_walls(), 0.25F) << "of a capsule that is taken to be 0.7 m too high";
    }
    // A sheep that comes over the border is simulated for two seconds.
    EXPECT_TRUE(!unseen || suspended > 300U * 24U * 8U / 10U) << suspended;
    return std::abs(turned) / (2.0 * M_PI);
}

/// Welch's test with 5 runs each; of 4 degrees of freedom, the fewest there can be, |t| exceeds 4.6
/// in one of a hundred cases in which nothing differs.
TEST(HerdInZones, GoesRoundOffscreenAsItDoesSeen) {
    constexpr int kRuns = 5;
    std::array<double, 2> mean{};
    std::array<double, 2> squares{};
    for (int seed = 1; seed <= kRuns; ++seed) {
        for (const bool unseen : {false, true}) {
            const double turns = turns_of(seed, unseen);
            mean[unseen ? 1 : 0] += turns / kRuns;
            squares[unseen ? 1 : 0] += turns * turns / kRuns;
        }
    }
    double variance = 1e-6;
    for (const std::size_t k : {0U, 1U}) {
        variance += std::max(0.0, squares[k] - mean[k] * mean[k]) / (kRuns - 1);
    }
    RecordProperty("seen", std::to_string(mean[0]));
    RecordProperty("unseen", std::to_string(mean[1]));
    EXPECT_LT(std::abs(mean[0] - mean[1]) / std::sqrt(variance), 4.6)
        << mean[0] << " turns seen, " << mean[1] << " unseen, deviation " << std::sqrt(variance);
    EXPECT_GT(mean[1], 0.8);
}

TEST(HerdInZones, GivesTheSameHashForOneAndFourThreads) {
    const std::string text =
        with(pastures(1, 600), "suspend_offscreen: false", "suspend_offscreen: true");
    Crowd one(text, 1U);
    Crowd four(text, 4U);
    for (int t = 0; t < 20 * 30; ++t) {
        one.tick();
        four.tick();
    }
    EXPECT_LT(centre_of(one).active, 100U);
    EXPECT_EQ(one.world().state_hash(), four.world().state_hash());
}

}  // namespace
}  // namespace zoned::app
