// RingStates: a state of the world beside the last inputs, so that they can be replayed after a
// crash (recording/crash_ring.h).
#pragma once

#include "server/app/recovery/process_copy.h"
#include "server/app/world/world.h"
#include "server/config/settings.h"
#include "server/recording/recorder.h"

#include <string>

namespace zoned::app {

/// Every recording.ring_s a copy of the process writes the state; the newest two are kept, with the
/// inputs since the older one. Where that fails it is tried half as often from time to time: a
/// world with a part that has no saved form will never have one. Nothing is written where another
/// server keeps its ring.
class RingStates {
  public:
    /// `header` is that of the ring's pieces.
    RingStates(const config::Settings& settings,
               std::string folder,
               recording::RecordingHeader header);

    /// After each tick, on the loop's thread. `recorder` keeps the ring.
    void after_tick(const World& world, recording::Recorder& recorder);

    /// Before the ring is closed: nothing more is written into its folder.
    void stop() { copy_.stop(); }

    /// How long the tick loop waited for each copy, ms.
    [[nodiscard]] const core::Histogram& pauses_ms() const { return copy_.pauses_ms(); }

  private:
    void take(const World& world, recording::Recorder& recorder);
    void look_after_copy(recording::Recorder& recorder);
    void fail(const std::string& why);

    std::string folder_;
    recording::RecordingHeader header_;
    Tick every_ticks_ = 1;
    Tick wait_ticks_ = 1;  // from one to the next; longer after failures
    Tick due_ = 0;         // the next one; 0: not known yet
    Tick started_ = 0;     // of the one that is being written
    Tick last_ = 0;        // of the newest that is on disk; 0: none
    ProcessCopy copy_;
};

}  // namespace zoned::app
