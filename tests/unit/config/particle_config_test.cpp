// Particle systems of a config: mistakes at their places, and the result of valid ones.
#include "server/config/world/particle_config.h"

#include "server/config/world/world_description.h"
#include "tests/unit/config/config_helpers.h"

namespace zoned::config::test {
namespace {

const std::string kSmoke = R"(particles {
  name: "smoke"
  emitter { x_m: 5 rate_hz: 10 }
  drag_per_s: 0.5
}
)";

const std::string kHail = R"(particles {
  name: "hail"
  cosmetic: false
  emitter { x_m: -20 y_m: 30 pitch_deg: -90 speed_min_mps: 5 speed_max_mps: 9 lifetime_min_s: 2 }
  burst { lifetime_min_s: 1 }
}
)";

const std::string kBirds = R"(particles {
  name: "birds"
  cosmetic: false
  emitter { y_m: 20 lifetime_min_s: 600 }
  flock { min_x_m: -40 max_x_m: 40 path { x_m: 0 } path { x_m: 20 } }
}
)";

std::string world_with(const std::string& particles) {
    return kValid + particles;
}

struct ParticleCase {
    std::string name;
    std::string from;
    std::string to;
    std::string needle;
    std::string words;
};

void PrintTo(const ParticleCase& c, std::ostream* out) {
    *out << c.name;
}

class ParticleMistake : public testing::TestWithParam<ParticleCase> {};

TEST_P(ParticleMistake, IsReportedAtItsPlace) {
    const ParticleCase& c = GetParam();
    expect_single(with(c.from, c.to, world_with(kSmoke + kHail)), c.needle, c.words);
}

const ParticleCase kParticleCases[] = {
    {"Nameless", "name: \"smoke\"\n", "", "particles {", "name"},
    {"NamedTwice",
     "name: \"hail\"",
     "name: \"smoke\"\n",
     "name: \"smoke\"\n\n",
     "'smoke' is given twice"},
    {"NoEmitter",
     "emitter { x_m: 5 rate_hz: 10 }",
     "",
     "particles {",
     "has neither an emitter nor a burst: nothing is ever born"},
    {"RateOutOfRange", "rate_hz: 10", "rate_hz: 0", "rate_hz: 0", "[0.001"},
    {"NegativeDrag", "drag_per_s: 0.5", "drag_per_s: -0.5", "drag_per_s: -0.5", "[0"},
    {"AuraOfASimulatedBurst",
     "burst { lifetime_min_s: 1",
     "burst { aura_m: 5 lifetime_min_s: 1",
     "aura_m: 5",
     "no meaning for a simulated system"},
    {"EventsOfASimulatedBurst",
     "burst { lifetime_min_s: 1",
     "burst { events_per_s: 5 lifetime_min_s: 1",
     "events_per_s: 5",
     "no meaning for a simulated system"},
    {"NoEvents",
     "drag_per_s: 0.5",
     "drag_per_s: 0.5 burst { events_per_s: 0 }",
     "events_per_s: 0",
     "[0.1"},
    {"RestitutionOutOfRange",
     "cosmetic: false",
     "cosmetic: false restitution: 1.5",
     "restitution: 1.5",
     "[0"},
    {"NoLifetime", "lifetime_min_s: 2", "lifetime_min_s: 0", "lifetime_min_s: 0", "[0.01"},
    {"SpeedsTheWrongWayRound",
     "speed_max_mps: 9",
     "speed_max_mps: 4",
     "speed_max_mps: 4",
     "less than speed_min_mps, 5"},
    {"LifetimesTheWrongWayRound",
     "lifetime_min_s: 2",
     "lifetime_min_s: 2 lifetime_max_s: 1.5",
     "lifetime_max_s: 1.5",
     "less than lifetime_min_s, 2"},
    {"BurstLifetimesTheWrongWayRound",
     "burst { lifetime_min_s: 1",
     "burst { lifetime_min_s: 1 lifetime_max_s: 0.5",
     "lifetime_max_s: 0.5",
     "less than lifetime_min_s, 1"},
    {"SimulatedOutsideTheWorld",
     "emitter { x_m: -20",
     "emitter { x_m: -2000",
     "emitter { x_m: -2000",
     "outside the world"},
    {"WindWithoutDrag",
     "cosmetic: false",
     "cosmetic: false wind { x_mps: 3 }",
     "wind { x_mps: 3 }",
     "no effect without drag_per_s"},
    {"CosmeticThatCollides",
     "drag_per_s: 0.5",
     "drag_per_s: 0.5 radius_m: 0.1",
     "radius_m: 0.1",
     "no meaning for a cosmetic system"},
    {"CosmeticWithGusts",
     "drag_per_s: 0.5",
     "drag_per_s: 0.5 wind { gust_mps: 2 }",
     "gust_mps: 2",
     "no meaning for a cosmetic system"},
    {"MoreThanClientsReplay",
     "rate_hz: 10",
     "rate_hz: 1000000 lifetime_min_s: 2",
     "particles {",
     "more than the 1e+06 that a client replays"},
    {"NamelessDevice", "spawn {", "compute { device: \"\" } spawn {", "device: \"\"", "bytes"},
};

class FlockMistake : public testing::TestWithParam<ParticleCase> {};

TEST_P(FlockMistake, IsReportedAtItsPlace) {
    const ParticleCase& c = GetParam();
    expect_single(with(c.from, c.to, world_with(kBirds)), c.needle, c.words);
}

const ParticleCase kFlockCases[] = {
    {"Cosmetic", "cosmetic: false", "cosmetic: true", "cosmetic: true", "set cosmetic: false"},
    {"Falls",
     "cosmetic: false",
     "cosmetic: false gravity_factor: 1",
     "gravity_factor: 1",
     "neither falls"},
    {"Meets",
     "cosmetic: false",
     "cosmetic: false characters_met: 1",
     "characters_met: 1",
     "neither falls"},
    {"Radii",
     "flock {",
     "flock { radius_m: 1",
     "radius_m: 1",
     "less than separation_radius_m, 1.5"},
    {"Speeds",
     "flock {",
     "flock { speed_max_mps: 3",
     "speed_max_mps: 3",
     "less than speed_min_mps, 4"},
    {"Home", "max_x_m: 40", "max_x_m: -50", "max_x_m: -50", "above min_x_m, -40"},
    {"Height", "flock {", "flock { min_y_m: 70", "flock {", "above min_y_m, 70"},
    {"OnePoint", "path { x_m: 20 }", "", "flock {", "two points"},
    {"NoPath",
     "path { x_m: 0 } path { x_m: 20 }",
     "closed: true",
     "flock {",
     "no meaning without a path"},
    {"Weight", "flock {", "flock { cohesion_per_s2: -1", "cohesion_per_s2: -1", "[0"},
};

INSTANTIATE_TEST_SUITE_P(Flocks, FlockMistake, testing::ValuesIn(kFlockCases), [](const auto& one) {
    return one.param.name;
});

TEST(ParticleSettings, GiveAFlockTheWorldForItsHomeWhereNoneIsGiven) {
    const Outcome out = parse(world_with(kBirds));
    ASSERT_TRUE(out.ok) << format_errors("test", out.errors);
    ASSERT_EQ(out.settings.particles.size(), 1U);
    ASSERT_TRUE(out.settings.particles[0].def.flock.has_value());
    const physics::FlockDef& flock = *out.settings.particles[0].def.flock;
    const auto& world = out.settings.config->world();
    EXPECT_EQ(flock.low, Vec3d(-40.0, 5.0, world.min_z_m()));
    EXPECT_EQ(flock.high, Vec3d(40.0, 60.0, world.max_z_m()));
    EXPECT_EQ(flock.path.size(), 2U);
    EXPECT_EQ(physics::unfit(out.settings.particles[0].def), "");
}

INSTANTIATE_TEST_SUITE_P(Particles,
                         ParticleMistake,
                         testing::ValuesIn(kParticleCases),
                         [](const auto& one) { return one.param.name; });

TEST(ParticleSettings, TellClientsOfCosmeticSystemsAndZonesOfTheOthers) {
    const Outcome out = parse(world_with(kSmoke + kHail));
    ASSERT_TRUE(out.ok) << format_errors("test", out.errors);
    ASSERT_EQ(out.settings.cosmetics.size(), 1u);
    ASSERT_EQ(out.settings.particles.size(), 1u);
    EXPECT_EQ(out.settings.cosmetics[0].name, "smoke");
    const zone::ParticleSource& hail = out.settings.particles[0];
    EXPECT_EQ(hail.def.name, "hail");
    EXPECT_TRUE(hail.burst.has_value());
    EXPECT_FLOAT_EQ(hail.def.gravity.y(), -9.81F);
    // 90 degrees down, within the rounding of a cosine.
    EXPECT_LT((hail.emitters[0].direction + Vec3::UnitY()).norm(), 1e-6F);
    EXPECT_EQ(hail.emitters[0].speed_max, 9.0F);
    EXPECT_EQ(hail.emitters[0].lifetime_max_s, 2.0F) << "as lifetime_min_s";
    EXPECT_EQ(most_particles(out.settings), 4096u);
    const proto::WorldDescription told = describe_world(out.settings);
    ASSERT_EQ(told.cosmetics_size(), 1);
    EXPECT_EQ(told.cosmetics(0).name(), "smoke");
    EXPECT_EQ(told.cosmetics(0).emitters(0).seed(), out.settings.cosmetics[0].emitters[0].seed);
}

TEST(ParticleSettings, TellClientsWhatBurstsHaveInCommonAndZonesWhoHears) {
    const std::string shards =
        "particles { name: \"shards\" burst { cone_deg: 60 slowest: 0.25 "
        "spread_m: 0.5 lifetime_min_s: 1.5 aura_m: 20 events_per_s: 7 } }\n";
    const Outcome out = parse(world_with(kSmoke + kHail + shards));
    ASSERT_TRUE(out.ok) << format_errors("test", out.errors);
    ASSERT_EQ(out.settings.particles.size(), 1u) << "it is not simulated";
    ASSERT_EQ(out.settings.cosmetic_bursts.size(), 1u);
    const zone::CosmeticBurst& burst = out.settings.cosmetic_bursts[0];
    EXPECT_EQ(burst.name, "shards");
    EXPECT_EQ(burst.system, 1u);
    EXPECT_EQ(burst.aura_m, 20.0F);
    EXPECT_EQ(burst.events_per_s, 7.0F);
    const proto::WorldDescription told = describe_world(out.settings);
    ASSERT_EQ(told.cosmetics_size(), 2);
    EXPECT_FALSE(told.cosmetics(0).has_burst());
    EXPECT_EQ(told.cosmetics(1).name(), "shards");
    EXPECT_EQ(told.cosmetics(1).emitters_size(), 0);
    EXPECT_NEAR(told.cosmetics(1).burst().cone_cosine(), 0.5, 1e-6);
    EXPECT_EQ(told.cosmetics(1).burst().cone_cosine(), burst.kind.cone_cosine);
    EXPECT_EQ(told.cosmetics(1).burst().slowest(), 0.25F);
    EXPECT_EQ(told.cosmetics(1).burst().spread(), 0.5F);
    EXPECT_EQ(told.cosmetics(1).burst().lifetime_min_s(), 1.5F);
    EXPECT_EQ(told.cosmetics(1).burst().lifetime_max_s(), 1.5F) << "as lifetime_min_s";
}

TEST(ParticleSettings, GiveEveryEmitterASeedOfItsOwnThatComesOfTheWorlds) {
    const std::string two = with("emitter { x_m: 5 rate_hz: 10 }",
                                 "emitter { rate_hz: 10 } emitter { rate_hz: 10 }",
                                 world_with(kSmoke));
    const auto seeds = [&](const std::string& seed) {
        const Outcome out = parse(two, {"world.seed=" + seed});
        EXPECT_TRUE(out.ok) << format_errors("test", out.errors);
        const auto& emitters = out.settings.cosmetics.at(0).emitters;
        return std::pair(emitters.at(0).seed, emitters.at(1).seed);
    };
    EXPECT_EQ(seeds("1"), seeds("1"));
    EXPECT_NE(seeds("1").first, seeds("1").second);
    EXPECT_NE(seeds("1").first, seeds("2").first);
}

}  // namespace
}  // namespace zoned::config::test
