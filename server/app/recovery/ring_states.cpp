#include "server/app/recovery/ring_states.h"

#include "server/app/log/log.h"
#include "server/recording/recording_file.h"

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <utility>

namespace zoned::app {

namespace {

/// Between two states, where they fail: multiples of the usual time.
constexpr Tick kLongestWait = 64;

/// Whole or not at all. Empty text: done.
std::string write_ring_state(const World& world,
                             const recording::RecordingHeader& header,
                             const std::string& folder) {
    recording::RecordedState state{world.now(), {}};
    const std::string wrong = world.save(state.bytes);
    if (!wrong.empty()) {
        return wrong;
    }
    const std::string file = recording::ring_state_file(folder, world.now());
    const std::string part = file + ".part";
    recording::RecordingFile out;
    const auto opened = out.open(part, header, &state);
    if (!opened.ok()) {
        return opened.error();
    }
    return std::rename(part.c_str(), file.c_str()) == 0 ? "" : std::strerror(errno);
}

}  // namespace

RingStates::RingStates(const config::Settings& settings,
                       std::string folder,
                       recording::RecordingHeader header)
    : folder_(std::move(folder)),
      header_(std::move(header)),
      every_ticks_(
          std::max<Tick>(1, static_cast<Tick>(settings.server.ring_s * settings.tick_rate_hz))),
      wait_ticks_(every_ticks_) {
}

void RingStates::after_tick(const World& world, recording::Recorder& recorder) {
    if (!recorder.keeps_ring()) {
        return;
    }
    look_after_copy(recorder);
    const Tick now = world.now();
    if (due_ == 0) {
        // A world that goes on from elsewhere cannot be replayed from tick 1.
        due_ = now <= 1 ? every_ticks_ : now;
    }
    if (now >= due_ && !copy_.works()) {
        take(world, recorder);
    }
}

void RingStates::take(const World& world, recording::Recorder& recorder) {
    started_ = world.now();
    due_ = started_ + wait_ticks_;
    recorder.cut_ring(started_);
    const std::string wrong =
        copy_.start([&] { return write_ring_state(world, header_, folder_); });
    if (!wrong.empty()) {
        fail(wrong);
    }
}

void RingStates::look_after_copy(recording::Recorder& recorder) {
    switch (copy_.look()) {
        case ProcessCopy::CopyEnd::kDone:
            recorder.keep_ring_from(last_ > 0 ? last_ : started_);
            last_ = started_;
            wait_ticks_ = every_ticks_;
            break;
        case ProcessCopy::CopyEnd::kFailed:
            fail("the copy of the process has told the reason");
            break;
        case ProcessCopy::CopyEnd::kNothing:
            break;
    }
}

void RingStates::fail(const std::string& why) {
    if (wait_ticks_ == every_ticks_) {
        log_of(LogArea::kServer)
            .warn(
                "no state beside the last inputs (recording.ring_s): a crash can be replayed from "
                "tick 1 alone: {}",
                why);
    }
    wait_ticks_ = std::min(2 * wait_ticks_, kLongestWait * every_ticks_);
    due_ = started_ + wait_ticks_;
}

}  // namespace zoned::app
