// The device for large particle systems: it is not opened without need. A problem with one is
// logged in one line that names the setting, and the CPU does the work.
#include "server/app/calibration/particle_device.h"

#include "server/app/runtime/tick_loop.h"
#include "server/app/world/world.h"
#include "server/config/expand/load_settings.h"

#include <gtest/gtest.h>
#include <spdlog/sinks/ostream_sink.h>
#include <spdlog/spdlog.h>
#include <unistd.h>

#include <chrono>
#include <filesystem>
#include <fstream>
#include <memory>
#include <optional>
#include <sstream>
#include <string>
#include <string_view>
#include <thread>
#include <vector>

namespace zoned::app {
namespace {

/// The minimal world with room for so many simulated particles in gusts, and a few in still air.
config::Settings with_particles(unsigned most, std::vector<std::string> more = {}) {
    std::vector<std::string> sets = {
        "particles[0]={name: \"hail\" cosmetic: false emitter { y_m: 20 } drag_per_s: 0.1 wind { "
        "gust_mps: 2 } most: " +
            std::to_string(most) + "}",
        "particles[1]={name: \"dust\" cosmetic: false emitter { y_m: 2 } most: 10}"};
    sets.insert(sets.end(), more.begin(), more.end());
    config::Settings settings;
    std::vector<config::ConfigError> errors;
    EXPECT_TRUE(
        config::load_settings(ZONED_SOURCE_DIR "/config/minimal.txtpb", sets, settings, errors));
    return settings;
}

constexpr unsigned kMany = 1U << 20U;

void expect_one_line(const std::string& text, const std::vector<std::string>& words) {
    EXPECT_EQ(text.find('\n'), std::string::npos) << text;
    EXPECT_LE(text.size(), 500u);
    for (const std::string& word : words) {
        EXPECT_NE(text.find(word), std::string::npos) << word << " in: " << text;
    }
}

TEST(ParticleDevice, IsNotLookedForWithoutNeed) {
    config::Settings none;
    std::vector<config::ConfigError> errors;
    ASSERT_TRUE(config::load_settings(ZONED_SOURCE_DIR "/config/minimal.txtpb", {}, none, errors));
    for (const config::Settings& settings :
         {none, with_particles(1000), with_particles(kMany, {"compute.device=none"})}) {
        const ParticleDevice device = open_particle_device(settings, 1);
        EXPECT_FALSE(device.needed) << device.text;
        EXPECT_FALSE(device.failed);
        EXPECT_EQ(device.device, nullptr);
    }
}

TEST(ParticleDevice, IsLookedForWhereTheCpuWouldTakeAHundredthOfATick) {
    // By the estimate: 8.9 ns a particle in gusts, 1 ns in still air; 333 us at 30 Hz.
    EXPECT_NEAR(particle_step_us(with_particles(30'000)), 267.01, 1e-6);
    EXPECT_FALSE(open_particle_device(with_particles(37'000), 1).needed);
    EXPECT_TRUE(open_particle_device(with_particles(38'000), 1).needed);
    EXPECT_TRUE(open_particle_device(with_particles(19'000, {"world.tick_rate_hz=60"}), 1).needed);
    // 16 balls: 77.7 ns.
    const std::string met = "particles[hail].characters_met=16";
    EXPECT_FALSE(open_particle_device(with_particles(4'200, {met}), 1).needed);
    EXPECT_TRUE(open_particle_device(with_particles(4'300, {met}), 1).needed);
}

TEST(ParticleDevice, IsOpenedMeasuredAndHasItsKernelsBuiltBeforeTheFirstTick) {
    const ParticleDevice device = open_particle_device(with_particles(kMany), 1);
    ASSERT_NE(device.device, nullptr) << device.text;
    EXPECT_TRUE(device.needed);
    EXPECT_FALSE(device.failed);
    EXPECT_TRUE(device.no_cache.empty()) << "none is asked for";
    EXPECT_TRUE(device.crossover.measured());
    // With gusts, which it was measured with, and without drag.
    EXPECT_EQ(device.device->programs().built, 2u);
    expect_one_line(device.text, {"particles: device ", "CPU "});
}

TEST(ParticleDevice, ThatNobodyHasIsToldWithTheSettingThatNamesIt) {
    const ParticleDevice device =
        open_particle_device(with_particles(kMany, {"compute.device=\"warp drive\""}), 1);
    EXPECT_TRUE(device.needed);
    EXPECT_TRUE(device.failed);
    EXPECT_EQ(device.device, nullptr);
    expect_one_line(device.text, {"on the CPU", "compute.device \"warp drive\""});
}

TEST(ParticleDevice, WhoseKernelsDoNotCompileIsGivenUpWithThePlaceOfTheMistake) {
    compute::DeviceSettings with;
    with.kernels = [](std::string_view) -> std::optional<std::string_view> {
        return "__kernel void particles_step( {\n  nonsense;\n}\n";
    };
    const ParticleDevice device = open_particle_device(with_particles(kMany), 1, with);
    EXPECT_TRUE(device.failed);
    EXPECT_EQ(device.device, nullptr);
    expect_one_line(device.text, {"on the CPU", "compute.device \"auto\"", "kernels/particles.cl"});
}

TEST(ParticleDevice, ThatRunsOutOfMemoryIsGivenUp) {
    compute::DeviceFaults faults;
    faults.memory_bytes = 1U << 16U;
    compute::DeviceSettings with;
    with.testing = &faults;
    const ParticleDevice device = open_particle_device(with_particles(kMany), 1, with);
    EXPECT_TRUE(device.failed);
    EXPECT_EQ(device.device, nullptr);
    expect_one_line(device.text, {"on the CPU", "compute.device \"auto\"", "memory"});
}

TEST(ParticleDevice, ThatFailsWhileItIsMeasuredIsGivenUp) {
    compute::DeviceFaults faults;
    faults.launches = 3;
    compute::DeviceSettings with;
    with.testing = &faults;
    const ParticleDevice device = open_particle_device(with_particles(kMany), 1, with);
    EXPECT_TRUE(device.failed);
    EXPECT_EQ(device.device, nullptr);
    expect_one_line(device.text, {"on the CPU", "failed"});
}

TEST(ParticleDevice, SaysWhereBuiltKernelsCannotBeKept) {
    const std::filesystem::path folder =
        std::filesystem::temp_directory_path() / ("zoned-cache-" + std::to_string(getpid()));
    std::filesystem::create_directories(folder);
    // A file where a folder should be: no user can write into it, not even root.
    std::ofstream(folder / "file") << "x";
    const std::string bad = (folder / "file" / "cache").string();
    const ParticleDevice refused =
        open_particle_device(with_particles(kMany, {"compute.cache_folder=\"" + bad + "\""}), 1);
    EXPECT_NE(refused.device, nullptr) << "it is merely slower to start";
    expect_one_line(refused.no_cache, {"compute.cache_folder \"" + bad + "\""});
    const std::string good = (folder / "cache").string();
    for (const unsigned built : {2U, 0U}) {
        const ParticleDevice kept = open_particle_device(
            with_particles(kMany, {"compute.cache_folder=\"" + good + "\""}), 1);
        EXPECT_EQ(kept.no_cache, "");
        ASSERT_NE(kept.device, nullptr) << kept.text;
        EXPECT_EQ(kept.device->programs().built, built) << "the second start finds them";
    }
    std::filesystem::remove_all(folder);
}

TEST(ParticleDevice, ThatDiesInPlayIsLoggedOnceAndTheWorldGoesOn) {
    compute::DeviceFaults faults;
    faults.launches = 5;
    compute::DeviceSettings with;
    with.testing = &faults;
    const auto device = compute::Device::open(with);
    ASSERT_TRUE(device.ok()) << device.error();
    std::ostringstream log;
    const auto before = spdlog::default_logger();
    spdlog::set_default_logger(std::make_shared<spdlog::logger>(
        "test", std::make_shared<spdlog::sinks::ostream_sink_mt>(log)));
    LoopStats stats;
    {
        const config::Settings settings = with_particles(1000);
        World world(settings, 1);
        // As if it were faster for any number.
        world.use_device(device->get(), {{1e6, 1.0, 0.0}, {0.0, 1e-6, 0.0}});
        LoopSettings fast;
        fast.rate_hz = 240.0;
        TickLoop loop(
            world, fast, [](TickResult) {}, nullptr);
        loop.start();
        for (int i = 0; i < 1000 && stats.ticks < 20; ++i) {
            std::this_thread::sleep_for(std::chrono::milliseconds(10));
            stats = loop.stats();
        }
        loop.stop();
    }
    spdlog::set_default_logger(before);
    EXPECT_GE(stats.ticks, 20) << "it goes on";
    EXPECT_EQ(stats.device_faults, 2u) << "both systems lost it";
    EXPECT_EQ(stats.device_particles, 5u);
    EXPECT_GT(stats.particles, 0u);
    const std::string text = log.str();
    const std::size_t first = text.find("the device is given up");
    ASSERT_NE(first, std::string::npos) << text;
    EXPECT_EQ(text.find("the device is given up", first + 1), std::string::npos) << text;
}

}  // namespace
}  // namespace zoned::app
