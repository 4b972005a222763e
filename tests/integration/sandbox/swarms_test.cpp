// The world whose particles are worth an OpenCL device: the same bits wherever each system runs.
#include "server/app/calibration/particle_device.h"
#include "server/app/world/world.h"
#include "server/compute/device.h"
#include "server/config/expand/load_settings.h"
#include "tests/harness/game_test.h"

#include <stdexcept>
#include <string>
#include <vector>

namespace zoned::harness {
namespace {

const std::string kSwarms = ZONED_SOURCE_DIR "/config/swarms.txtpb";
constexpr int kSwarmTicks = 60;
constexpr std::size_t kBirds = 30'000;

config::Settings swarm_settings() {
    config::Settings settings;
    std::vector<config::ConfigError> errors;
    if (!config::load_settings(kSwarms, {}, settings, errors)) {
        throw std::runtime_error(config::format_errors(kSwarms, errors));
    }
    return settings;
}

/// Counts over some ticks.
struct SwarmCounts {
    std::size_t particles = 0;  ///< in the last tick
    unsigned on_device = 0;     ///< systems moved by a device, over all ticks
    unsigned faults = 0;        ///< systems that gave their device up
};

/// Ticks a world and keeps its state hash of each tick.
SwarmCounts tick_swarms(app::World& world, std::vector<std::uint64_t>& hashes) {
    SwarmCounts counts;
    std::vector<mailbox::OutboxItem> out;
    for (int t = 0; t < kSwarmTicks; ++t) {
        world.tick({}, out);
        out.clear();
        hashes.push_back(world.state_hash());
        const auto& particles = world.zones()[0]->report().particles;
        counts.particles = particles.particles;
        counts.on_device += particles.on_device;
        counts.faults += particles.fault.empty() ? 0 : 1;
    }
    return counts;
}

TEST(Swarms, AreWorthADeviceWhichIsMeasuredForBothKindsOfSystem) {
    const config::Settings settings = swarm_settings();
    const app::ParticleDevice device = app::open_particle_device(settings, 2);
    EXPECT_TRUE(device.needed);
    ASSERT_NE(device.device, nullptr) << device.text;
    EXPECT_TRUE(device.crossover.measured());
    EXPECT_TRUE(device.of_flocks.measured());
}

TEST(Swarms, HaveTheSameBitsOnThreadsOnADeviceAndOnOneThatFails) {
    const config::Settings settings = swarm_settings();
    // As if the device were faster for any number.
    const compute::Crossover device_for_all({1e6, 1.0, 0.0}, {0.0, 1e-6, 0.0});
    std::vector<std::uint64_t> on_cpu;
    app::World cpu(settings, 1);
    const SwarmCounts alone = tick_swarms(cpu, on_cpu);
    EXPECT_GT(alone.particles, kBirds) << "birds and sand";
    EXPECT_EQ(alone.on_device, 0u);

    std::vector<std::uint64_t> on_threads;
    app::World threads(settings, 3);
    tick_swarms(threads, on_threads);
    EXPECT_EQ(on_threads, on_cpu);

    const auto device = compute::Device::open({});
    ASSERT_TRUE(device.ok()) << device.error();
    std::vector<std::uint64_t> on_device;
    app::World moved(settings, 2);
    moved.use_device(device->get(), device_for_all, device_for_all);
    // In the first tick nothing is born yet.
    EXPECT_EQ(tick_swarms(moved, on_device).on_device, 2u * (kSwarmTicks - 1));
    EXPECT_EQ(on_device, on_cpu);

    compute::DeviceFaults faults;
    faults.launches = 100;  // some of the 60 ticks' launches
    compute::DeviceSettings open;
    open.testing = &faults;
    const auto broken = compute::Device::open(open);
    ASSERT_TRUE(broken.ok()) << broken.error();
    std::vector<std::uint64_t> on_both;
    app::World failing(settings, 2);
    failing.use_device(broken->get(), device_for_all, device_for_all);
    const SwarmCounts counts = tick_swarms(failing, on_both);
    EXPECT_GT(counts.on_device, 0u);
    EXPECT_LT(counts.on_device, 2u * (kSwarmTicks - 1));
    EXPECT_GT(counts.faults, 0u);
    EXPECT_EQ(on_both, on_cpu);
}

class SwarmsTest : public GameTest {
  protected:
    SwarmsTest() { server.config = kSwarms; }
};

TEST_F(SwarmsTest, IsConsistentOnABadNetwork) {
    bots.bots = 20;
    bots.seconds = 8.0;
    server.network.loss = 0.05;
    server.network.delay_s = 0.06;
    server.network.jitter_s = 0.02;
    const measure::RunReport report = run();
    EXPECT_TRUE(report.consistent) << reasons(report);
    EXPECT_EQ(report.converged_bots, 20u);
}

}  // namespace
}  // namespace zoned::harness
