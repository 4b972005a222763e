#include "server/app/replay/replay_loop.h"

#include "server/config/expand/load_settings.h"
#include "server/recording/recording_file.h"

#include <gtest/gtest.h>

#include <chrono>
#include <filesystem>
#include <thread>

namespace zoned::app {
namespace {

constexpr Tick kTicks = 1000;

config::Settings minimal_world() {
    config::Settings settings;
    std::vector<config::ConfigError> errors;
    EXPECT_TRUE(
        config::load_settings(ZONED_SOURCE_DIR "/config/minimal.txtpb", {}, settings, errors));
    return settings;
}

void record(const config::Settings& settings, const std::string& file) {
    recording::RecordingHeader header = recording::RecordingHeader::of_this_build();
    header.config_text = settings.text;
    header.config_digest = settings.digest;
    recording::RecordingFile out;
    ASSERT_TRUE(out.open(file, header).ok());
    World world(settings, 1);
    std::vector<mailbox::OutboxItem> outbox;
    recording::TickRecord tick;
    while (world.now() < kTicks) {
        tick.tick = world.now() + 1;
        tick.items.clear();
        if (tick.tick == 5) {
            tick.items.emplace_back(
                mailbox::Join{ClientId(1), "ann", "red", 3, {0.0, 0.0, 0.0}, "", false});
        }
        world.tick(tick.items, outbox);
        outbox.clear();
        world.hash_zones(tick.hashes);
        out.add_tick(tick);
    }
    ASSERT_TRUE(out.close().ok());
}

/// Seeks and waits until the tick is there.
ReplayState go_to(ReplayLoop& loop, Tick tick) {
    loop.seek(tick);
    const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(60);
    ReplayState state = loop.state();
    while ((state.target != 0 || state.tick != tick) && std::chrono::steady_clock::now() < end) {
        std::this_thread::yield();
        state = loop.state();
    }
    return state;
}

TEST(ReplayLoop, GoesBackFromTheLastSnapshotBeforeTheTick) {
    const std::string file =
        (std::filesystem::temp_directory_path() / "zoned_replay_loop_test.zrec").string();
    const config::Settings settings = minimal_world();
    record(settings, file);
    ReplayLoop loop(settings, file, 1);
    ASSERT_TRUE(loop.open().ok());
    loop.set_time_scale(0.0);
    loop.start();
    const ReplayState there = go_to(loop, 950);
    EXPECT_EQ(there.tick, 950);
    EXPECT_EQ(there.simulated, 950U);
    const ReplayState back = go_to(loop, 640);
    EXPECT_EQ(back.tick, 640);
    EXPECT_EQ(back.simulated, 990U) << "from the snapshot of tick 600 on";
    const ReplayState early = go_to(loop, 10);
    EXPECT_EQ(early.simulated, 1000U) << "from tick 1 on";
    const ReplayState forth = go_to(loop, 910);
    EXPECT_EQ(forth.simulated, 1010U) << "from the snapshot of tick 900 on";
    EXPECT_EQ(forth.fault, "");
    EXPECT_FALSE(forth.differs);
    loop.stop();
    std::filesystem::remove(file);
}

}  // namespace
}  // namespace zoned::app
