// Particles in zones: those that rules query are simulated, purely cosmetic ones are not.
#include "client-sim/view/world_info.h"
#include "server/app/world/world.h"
#include "server/compute/device.h"
#include "server/config/expand/load_settings.h"
#include "server/config/world/world_description.h"
#include "server/zone/context/zone_context.h"
#include "tests/harness/game_test.h"
#include "tests/harness/received.h"

#include <algorithm>
#include <cmath>

namespace zoned::harness {
namespace {

const std::string kWeather = ZONED_SOURCE_DIR "/config/weather.txtpb";

config::Settings weather(const std::vector<std::string>& sets = {}) {
    config::Settings settings;
    std::vector<config::ConfigError> errors;
    EXPECT_TRUE(config::load_settings(kWeather, sets, settings, errors))
        << config::format_errors(kWeather, errors);
    return settings;
}

/// With a simulated system that rules may let bursts out of, beside the cosmetic debris.
config::Settings weather_with_gravel(std::vector<std::string> sets = {}) {
    sets.insert(
        sets.begin(),
        "particles[4]={name: \"gravel\" cosmetic: false drag_per_s: 0.2 radius_m: 0.02 most: "
        "1000 burst { cone_deg: 50 slowest: 0.3 lifetime_min_s: 1 lifetime_max_s: 3 } }");
    return weather(sets);
}

void pass_ticks(app::World& world, int ticks) {
    std::vector<mailbox::OutboxItem> out;
    for (int t = 0; t < ticks; ++t) {
        world.tick({}, out);
        out.clear();
    }
}

class Weather : public GameTest {
  protected:
    Weather() { server.config = kWeather; }
};

TEST_F(Weather, IsSeenAsPromisedAndTheSameForAnyNumberOfThreads) {
    bots.bots = 20;
    bots.seconds = 10.0;
    std::uint64_t hashes[2] = {};
    std::size_t hail = 0;
    for (unsigned threads : {1U, 2U}) {
        server.threads = threads;
        const measure::RunReport report = run([&](VirtualServer& w, double) {
            for (const auto& zone : w.world().zones()) {
                hail = std::max(hail, zone->report().particles.particles);
            }
        });
        EXPECT_TRUE(report.consistent) << reasons(report);
        EXPECT_EQ(report.converged_bots, 20u);
        hashes[threads - 1] = world->world().state_hash();
    }
    EXPECT_EQ(hashes[0], hashes[1]);
    // 200 a second for three to five seconds.
    EXPECT_GE(hail, 600u);
}

TEST(ParticlesInZones, LiveOnlyInTheZonesWhereTheirEmittersAre) {
    const config::Settings settings = weather({"particles[hail].emitter[1].x_m=-25"});
    app::World world(settings, 1);
    pass_ticks(world, 60);
    const auto& west = world.zones()[0]->state();
    const auto& east = world.zones()[1]->state();
    // 2 x 200 a second for two seconds, none of which is old enough to be gone.
    EXPECT_EQ(west.report.particles.particles, 800u);
    EXPECT_EQ(east.report.particles.particles, 0u);
    // Rain and smoke are no part of the server's state.
    EXPECT_EQ(west.particles.systems.size(), 1u);
    EXPECT_TRUE(east.particles.systems.empty());
    EXPECT_EQ(settings.cosmetics.size(), 3u);
    EXPECT_TRUE(west.report.plan.has(zone::Pass::kParticles));
    EXPECT_FALSE(east.report.plan.has(zone::Pass::kParticles));
    EXPECT_EQ(east.report.plan.reason[static_cast<std::size_t>(zone::Pass::kParticles)],
              "no particles that rules ask about");
}

/// Home and path are given in the world's coordinates: 40 x 20 x 40 m about (25, 20, -20) in the
/// eastern zone. An animal comes out by v2 / (2 a) at most, with 12 m/s and the 5 m/s2 that turning
/// back is more than the flock's own acceleration, and by a step.
TEST(ParticlesInZones, AFlockStaysAboutItsHomeInTheWorld) {
    const config::Settings settings = weather(
        {"particles[4]={name: \"birds\" cosmetic: false most: 100 emitter { x_m: 25 y_m: 20 z_m: "
         "-20 spread_m: 5 rate_hz: 100 cone_deg: 180 speed_min_mps: 6 lifetime_min_s: 600 } flock "
         "{ max_acceleration_mps2: 5 min_x_m: 5 max_x_m: 45 min_y_m: 10 max_y_m: 30 min_z_m: -40 "
         "max_z_m: 0 path { x_m: 15 "
         "z_m: -30 } path { x_m: 35 z_m: -10 } } }"});
    app::World world(settings, 1);
    pass_ticks(world, 600);
    EXPECT_EQ(world.zones()[0]->state().particles.systems.size(), 1U) << "hail alone";
    const zone::ZoneState& east = world.zones()[1]->state();
    const auto it = std::find_if(east.particles.systems.begin(),
                                 east.particles.systems.end(),
                                 [](const auto& system) { return system.name == "birds"; });
    ASSERT_NE(it, east.particles.systems.end());
    const physics::ParticleSystem& birds = *east.particles.simulated.find(it->id);
    EXPECT_EQ(birds.size(), 100U);
    Vec3d mean = Vec3d::Zero();
    for (std::size_t i = 0; i < birds.size(); ++i) {
        const Vec3d at = birds.position(i).cast<double>() + east.settings.region().origin();
        mean += at / static_cast<double>(birds.size());
        EXPECT_LT((at - Vec3d(25.0, 20.0, -20.0)).cwiseAbs().maxCoeff(),
                  20.0 + 12.0 * 12.0 / (2.0 * 5.0) + 12.0 / settings.tick_rate_hz)
            << at.transpose();
    }
    // The path has led them to its end.
    EXPECT_LT(std::hypot(mean.x() - 35.0, mean.z() + 10.0), 15.0) << mean.transpose();
}

TEST(CosmeticParticles, AreReplayedByClientsAsTheServersClosedFormSays) {
    const config::Settings settings = weather();
    const auto told = view::read_world(
        test::received<wire::WorldDescriptionMessage>(config::describe_world(settings)));
    ASSERT_TRUE(told.ok()) << told.error();
    ASSERT_EQ(told->cosmetics.size(), settings.cosmetics.size());
    for (std::size_t s = 0; s < settings.cosmetics.size(); ++s) {
        const config::CosmeticSystem& mine = settings.cosmetics[s];
        if (mine.emitters.empty()) {
            continue;  // let out by events alone
        }
        std::vector<motion::CosmeticParticle> here;
        std::vector<motion::CosmeticParticle> there;
        motion::replay({mine.emitters[0], mine.gravity, mine.drag, mine.wind},
                       1000,
                       1.0 / settings.tick_rate_hz,
                       here);
        motion::replay(told->cosmetics[s].emitters[0], 1000, told->tick_s, there);
        ASSERT_EQ(here.size(), there.size());
        EXPECT_GT(here.size(), 100u);
        for (std::size_t i = 0; i < here.size(); ++i) {
            EXPECT_EQ(here[i].position, there[i].position);
        }
    }
}

TEST(ParticlesInZones, AreNoPassWhereTheWorldHasNone) {
    config::Settings settings;
    std::vector<config::ConfigError> errors;
    ASSERT_TRUE(
        config::load_settings(ZONED_SOURCE_DIR "/config/minimal.txtpb", {}, settings, errors));
    app::World world(settings, 1);
    pass_ticks(world, 1);
    const zone::StepReport& report = world.zones()[0]->report();
    EXPECT_FALSE(report.plan.has(zone::Pass::kParticles));
    EXPECT_EQ(report.plan.reason[static_cast<std::size_t>(zone::Pass::kParticles)],
              "no particles that rules ask about");
}

TEST(ParticlesInZones, AreLetOutAndCountedByRules) {
    const config::Settings settings = weather_with_gravel();
    app::World world(settings, 1);
    pass_ticks(world, 1);
    zone::ZoneState& state = world.zones()[0]->state();
    zone::ZoneContext context(state);
    const Vec3 at(3.0F, 5.0F, 2.0F);
    EXPECT_FALSE(context.emit("hail", at, Vec3::UnitY(), 5)) << "it has no burst";
    EXPECT_FALSE(context.emit("rain", at, Vec3::UnitY(), 5)) << "it is cosmetic";
    EXPECT_FALSE(context.emit("gravel", at, Vec3::UnitY(), 0));
    EXPECT_FALSE(context.emit("gravel", at, Vec3::Constant(NAN), 5));
    ASSERT_TRUE(context.emit("gravel", at, 3.0F * Vec3::UnitY(), 40));
    EXPECT_EQ(context.particles_near("gravel", at, 100.0F), 0u) << "born in the next tick";
    pass_ticks(world, 1);
    // In one tick none flies farther than the speed and gravity take it: 3 m/s / 30 Hz.
    EXPECT_EQ(context.particles_near("gravel", at, 0.11F), 40u);
    EXPECT_EQ(context.particles_near("gravel", at + Vec3(1.0F, 0.0F, 0.0F), 0.5F), 0u);
    EXPECT_EQ(context.particles_near("rain", at, 100.0F), 0u);
    // They live for one to three seconds, and lie on the ground at the end.
    pass_ticks(world, 26);
    EXPECT_EQ(context.particles_near("gravel", at, 100.0F), 40u);
    pass_ticks(world, 70);
    EXPECT_EQ(context.particles_near("gravel", at, 100.0F), 0u);
}

TEST(ParticlesInZones, AreNotBornBeyondTheirMost) {
    const config::Settings settings = weather_with_gravel({"particles[gravel].most=30"});
    app::World world(settings, 1);
    pass_ticks(world, 1);
    zone::ZoneContext context(world.zones()[0]->state());
    ASSERT_TRUE(context.emit("gravel", Vec3(0.0F, 5.0F, 0.0F), Vec3::UnitY(), 40));
    pass_ticks(world, 1);
    EXPECT_EQ(context.particles_near("gravel", Vec3(0.0F, 5.0F, 0.0F), 10.0F), 30u);
    EXPECT_EQ(world.zones()[0]->report().particles.counts.refused, 10u);
}

TEST(ParticlesInZones, ShowInTheStateHash) {
    const config::Settings settings = weather_with_gravel();
    std::uint64_t hashes[3] = {};
    for (int i = 0; i < 3; ++i) {
        app::World world(settings, 1);
        pass_ticks(world, 10);
        if (i > 0) {
            // One particle more, in one of the runs elsewhere by a centimetre.
            zone::ZoneContext context(world.zones()[0]->state());
            context.emit(
                "gravel", Vec3(0.01F * static_cast<float>(i), 5.0F, 0.0F), Vec3::UnitY(), 1);
        }
        pass_ticks(world, 2);
        hashes[i] = world.state_hash();
    }
    EXPECT_NE(hashes[0], hashes[1]);
    EXPECT_NE(hashes[1], hashes[2]);
}

TEST(ParticlesInZones, RestOnceAllAreGoneAndNoneWillBeBorn) {
    const config::Settings settings = weather_with_gravel(
        {"particles[hail].emitter[0].most=1", "particles[hail].emitter[1].x_m=-25"});
    app::World world(settings, 1);
    pass_ticks(world, 5);
    const zone::StepReport& east = world.zones()[1]->report();
    EXPECT_EQ(east.census.particle_systems, 1u) << "the gravel";
    EXPECT_FALSE(east.plan.has(zone::Pass::kParticles));
    EXPECT_EQ(east.plan.reason[static_cast<std::size_t>(zone::Pass::kParticles)],
              "all particles are gone and no emitter goes on");
}

TEST(ParticlesInZones, BounceOffTheGroundAndOffCharacters) {
    // Straight down onto a player who stands below: without being met, all would reach the ground.
    const std::vector<std::string> sets = {"particles[hail].emitter[0].spread_m=0.05",
                                           "particles[hail].emitter[0].cone_deg=0",
                                           "particles[hail].emitter[0].y_m=10",
                                           "particles[hail].wind={}",
                                           "spawn[4].x_m=-20",
                                           "spawn[4].z_m=10",
                                           "rules[1].value=0"};
    std::uint32_t under_head[2] = {};
    for (const int met : {0, 8}) {
        std::vector<std::string> all = sets;
        all.push_back("particles[hail].characters_met=" + std::to_string(met));
        // The player is spawned where the first number of a client leads.
        for (const char* point : {"1", "2", "3"}) {
            all.push_back("spawn[" + std::string(point) + "].x_m=-20");
            all.push_back("spawn[" + std::string(point) + "].z_m=10");
        }
        const config::Settings settings = weather(all);
        app::World world(settings, 1);
        mailbox::Join join;
        join.client = ClientId(1);
        join.name = "one";
        const std::vector<mailbox::InboxItem> items = {join};
        std::vector<mailbox::OutboxItem> out;
        world.tick(items, out);
        pass_ticks(world, 60);
        const zone::ZoneState& state = world.zones()[0]->state();
        const world::Row player = state.entities.find(state.clients[0].avatar);
        const Vec3 at = state.entities.position[player];
        const physics::ParticleSystem& hail =
            *state.particles.simulated.find(state.particles.systems[0].id);
        ASSERT_GT(hail.size(), 300u);
        for (std::size_t i = 0; i < hail.size(); ++i) {
            EXPECT_GE(hail.position(i).y(), 0.0099F);
            under_head[met > 0 ? 1 : 0] += (hail.position(i) - at).norm() < 0.85F ? 1U : 0U;
        }
    }
    EXPECT_GT(under_head[0], 20u);
    EXPECT_EQ(under_head[1], 0u) << "the ball around a character is 0.9 m wide";
}

TEST(ParticlesInZones, LieOnHillsAndNotInThem) {
    config::Settings settings;
    std::vector<config::ConfigError> errors;
    ASSERT_TRUE(config::load_settings(
        ZONED_SOURCE_DIR "/config/hills.txtpb",
        {"particles[0]={name: \"hail\" cosmetic: false radius_m: 0.05 emitter { x_m: -10 y_m: 30 "
         "spread_m: 8 rate_hz: 100 speed_min_mps: 0 lifetime_min_s: 60 }}"},
        settings,
        errors))
        << config::format_errors("hills", errors);
    app::World world(settings, 1);
    pass_ticks(world, 300);
    float highest = 0.0F;
    std::size_t seen = 0;
    for (const auto& zone : world.zones()) {
        const zone::ZoneState& state = zone->state();
        if (state.particles.systems.empty()) {
            continue;
        }
        zone::ZoneContext context(zone->state());
        const auto& hail = *state.particles.simulated.find(state.particles.systems[0].id);
        for (std::size_t i = 0; i < hail.size(); ++i) {
            const Vec3 at = hail.position(i);
            const zone::RayResult below =
                context.ray_cast(Vec3(at.x(), 60.0F, at.z()), -Vec3::UnitY(), 100.0F, EntityId());
            ASSERT_TRUE(below.hit);
            ++seen;
            if (below.entity) {
                continue;  // a prop stands here, which particles fly through
            }
            // Each step pushes it out along the normal; a step of sliding may take it in again by
            // the slope's change between two triangles.
            EXPECT_GE(at.y(), below.point.y() - 0.05F) << at.transpose();
            highest = std::max(highest, below.point.y());
        }
    }
    EXPECT_EQ(seen, 1000u);
    EXPECT_GT(highest, 1.0F) << "no hill lies under the cloud";
}

/// As if the device were faster for any number.
const compute::Crossover kAlwaysDevice({1e6, 1.0, 0.0}, {0.0, 1e-6, 0.0});

TEST(ParticlesInZones, GoOnWithTheSameHashWhereTheirDeviceFails) {
    for (const bool memory : {false, true}) {
        compute::DeviceFaults faults;
        faults.launches = memory ? -1 : 5;
        faults.memory_bytes = memory ? 1U << 16U : SIZE_MAX;
        compute::DeviceSettings open;
        open.testing = &faults;
        const auto device = compute::Device::open(open);
        ASSERT_TRUE(device.ok()) << device.error();
        const config::Settings settings = weather();
        app::World on_cpu(settings, 1);
        app::World on_device(settings, 1);
        on_device.use_device(device->get(), kAlwaysDevice);
        std::vector<mailbox::OutboxItem> out;
        unsigned moved = 0;
        std::vector<std::string> told;
        for (int t = 0; t < 30; ++t) {
            on_cpu.tick({}, out);
            on_device.tick({}, out);
            ASSERT_EQ(on_cpu.state_hash(), on_device.state_hash()) << t;
            for (const auto& zone : on_device.zones()) {
                moved += zone->report().particles.on_device;
                if (!zone->report().particles.fault.empty()) {
                    told.push_back(zone->report().particles.fault);
                }
            }
        }
        // Each of the two systems gives it up, once; one of buffers too large was of no use ever.
        EXPECT_EQ(told.size(), 2u);
        EXPECT_EQ(moved > 0, !memory);
        EXPECT_EQ((*device)->lost(), !memory);
        EXPECT_EQ(told.at(0).find("memory") != std::string::npos, memory) << told.at(0);
        // The worlds end before their device.
    }
}

/// All bursts that zones let out, as emitters in world coordinates.
class BurstLog {
  public:
    void add(const app::World& world, const config::Settings& settings) {
        if (world.now() == seen_) {
            return;
        }
        seen_ = world.now();
        for (const auto& zone : world.zones()) {
            for (const zone::BurstOut& out : zone->output().bursts) {
                const config::CosmeticSystem& system = settings.cosmetics.at(out.system);
                all_.push_back({motion::emitter_of(*system.burst, out.burst),
                                system.gravity,
                                system.drag,
                                system.wind});
            }
        }
    }

    [[nodiscard]] std::size_t size() const { return all_.size(); }

    /// Whether one of the bursts has such a particle at a tick, bit for bit.
    [[nodiscard]] bool has(const motion::CosmeticParticle& spark, Tick tick, double tick_s) const {
        return std::any_of(all_.begin(), all_.end(), [&](const motion::CosmeticEmitter& burst) {
            std::vector<motion::CosmeticParticle> mine;
            motion::replay(burst, tick, tick_s, mine);
            return std::any_of(mine.begin(), mine.end(), [&](const motion::CosmeticParticle& m) {
                return m.index == spark.index && m.position == spark.position &&
                       m.velocity == spark.velocity;
            });
        });
    }

  private:
    std::vector<motion::CosmeticEmitter> all_;
    Tick seen_ = 0;
};

TEST_F(Weather, ShowsBotsTheDebrisThatItsHitsThrowUpAndSimulatesNoneOfIt) {
    bots.bots = 12;
    bots.seconds = 10.0;
    bots.mix = bot::parse_mix("fight:1").value();
    BurstLog log;
    std::size_t compared = 0;
    std::size_t astray = 0;
    std::size_t others = 0;
    const measure::RunReport report = run([&](VirtualServer& w, double now_s) {
        log.add(w.world(), w.settings());
        for (const auto& zone : w.world().zones()) {
            others += zone->report().census.particle_systems > 1 ? 1 : 0;  // than the hail
        }
        const bool look = std::fmod(now_s, 0.5) < w.world().zones()[0]->state().settings.dt;
        for (std::size_t b = 0; look && b < swarm->bots().size(); ++b) {
            const view::View* view = swarm->bots()[b]->view();
            if (view == nullptr) {
                continue;
            }
            std::vector<motion::CosmeticParticle> sparks;
            view->bursts().replay(view->tick(), sparks);
            for (const motion::CosmeticParticle& spark : sparks) {
                ++compared;
                astray += log.has(spark, view->tick(), view->world().tick_s) ? 0 : 1;
            }
        }
    });
    EXPECT_TRUE(report.consistent) << reasons(report);
    EXPECT_GT(log.size(), 0u) << "nobody hit anything";
    EXPECT_GT(report.bursts, 0u);
    EXPECT_EQ(report.bursts_malformed, 0u);
    EXPECT_GT(compared, 0u);
    EXPECT_EQ(astray, 0u);
    EXPECT_EQ(others, 0u);
    EXPECT_GT(world->world().bursts_sent(), 0u);
}

}  // namespace
}  // namespace zoned::harness
