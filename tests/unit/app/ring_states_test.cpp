// RingStates: where no state is written, and how often it is tried where it fails.
#include "server/app/recovery/ring_states.h"

#include "server/config/expand/load_settings.h"

#include <gtest/gtest.h>

#include <chrono>
#include <filesystem>
#include <memory>
#include <string>
#include <thread>

namespace zoned::app {
namespace {

namespace fs = std::filesystem;

class StatesOfARing : public testing::Test {
  protected:
    StatesOfARing() {
        fs::remove_all(folder);
        std::vector<config::ConfigError> errors;
        EXPECT_TRUE(config::load_settings(ZONED_SOURCE_DIR "/config/minimal.txtpb",
                                          {"recording.ring_s=0.1"},  // three ticks
                                          settings,
                                          errors));
        world = std::make_unique<World>(settings, 1);
    }

    ~StatesOfARing() override { fs::remove_all(folder); }

    [[nodiscard]] recording::RecordingHeader header() const {
        recording::RecordingHeader out = recording::RecordingHeader::of_this_build();
        out.config_digest = settings.digest;
        return out;
    }

    std::unique_ptr<recording::Recorder> open_recorder() {
        recording::RecorderSettings s;
        s.header = header();
        s.ring_folder = folder + "/ring";
        s.ring_s = settings.server.ring_s;
        s.rate_hz = settings.tick_rate_hz;
        auto recorder = std::make_unique<recording::Recorder>(s, [](const std::string&) {});
        EXPECT_TRUE(recorder->open().ok());
        return recorder;
    }

    /// Each tick leaves a copy of the process some time to end.
    void play(RingStates& states, recording::Recorder& recorder, int ticks) {
        std::vector<mailbox::OutboxItem> out;
        for (int t = 0; t < ticks; ++t) {
            out.clear();
            world->tick({}, out);
            states.after_tick(*world, recorder);
            std::this_thread::sleep_for(std::chrono::milliseconds(5));
        }
        states.stop();
    }

    [[nodiscard]] bool holds_states() const {
        for (const auto& entry : fs::directory_iterator(folder + "/ring")) {
            if (entry.path().string().find("-state") != std::string::npos) {
                return true;
            }
        }
        return false;
    }

    std::string folder = testing::TempDir() + "zoned_ring_states_" +
                         testing::UnitTest::GetInstance()->current_test_info()->name();
    config::Settings settings;
    std::unique_ptr<World> world;
};

TEST_F(StatesOfARing, AreNotWrittenIntoTheRingOfAnotherServer) {
    const auto first = open_recorder();
    const auto second = open_recorder();
    RingStates states(settings, folder + "/ring", header());
    play(states, *second, 20);
    EXPECT_FALSE(holds_states());
    EXPECT_EQ(states.pauses_ms().count(), 0U);
    play(states, *first, 20);
    EXPECT_TRUE(holds_states());
    EXPECT_TRUE(first->close().ok());
    EXPECT_FALSE(holds_states());
}

TEST_F(StatesOfARing, AreTriedLessOftenWhereTheyFail) {
    const auto recorder = open_recorder();
    RingStates states(settings, folder + "/no such folder", header());
    play(states, *recorder, 190);
    // After 3, 9, 21, 45, 93 and 189 ticks, not 63 times. A copy that takes longer makes it fewer.
    EXPECT_LE(states.pauses_ms().count(), 6U);
    EXPECT_GE(states.pauses_ms().count(), 2U);
}

}  // namespace
}  // namespace zoned::app
