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
          std::max<Tick>(1, static_cast<Tick>(settings.server.ring_s * settings.tick_rate_hz))) {
}

void RingStates::after_tick(const World& world, recording::Recorder& recorder) {
    const Tick now = world.now();
    switch (copy_.look()) {
        case ProcessCopy::CopyEnd::kDone:
            recorder.keep_ring_from(last_ > 0 ? last_ : started_);
            last_ = started_;
            failing_ = false;
            break;
        case ProcessCopy::CopyEnd::kFailed:
            if (!failing_) {
                failing_ = true;
                log_of(LogArea::kServer)
                    .warn(
                        "no state beside the last inputs (recording.ring_s): a crash can be "
                        "replayed from tick 1 alone");
            }
            break;
        case ProcessCopy::CopyEnd::kNothing:
            break;
    }
    if (due_ == 0) {
        // A world that goes on from elsewhere cannot be replayed from tick 1.
        due_ = now <= 1 ? every_ticks_ : now;
    }
    if (now < due_ || copy_.works()) {
        return;
    }
    due_ = now + every_ticks_;
    started_ = now;
    recorder.cut_ring(now);
    const std::string wrong =
        copy_.start([&] { return write_ring_state(world, header_, folder_); });
    if (!wrong.empty()) {
        log_of(LogArea::kServer).error("no state beside the last inputs: {}", wrong);
    }
}

}  // namespace zoned::app
