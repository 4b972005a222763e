// ReplayLoop: plays a recording on a thread of its own, at any pace, from any of its ticks on.
#pragma once

#include "server/app/runtime/tick_loop.h"
#include "server/app/runtime/visited_world.h"
#include "server/config/settings.h"
#include "server/mailbox/latest.h"
#include "server/recording/recording_reader.h"
#include "shared/core/result.h"

#include <atomic>
#include <cstdint>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

namespace zoned::app {

/// A recording's place and course.
struct ReplayState {
    Tick last = 0;         ///< of the recording
    Tick tick = 0;         ///< that is shown
    Tick target = 0;       ///< that is being simulated to; 0: none
    std::string fault;     ///< what differed, or where the file is damaged; empty: nothing so far
    bool differs = false;  ///< a hash was not the recorded one
    std::uint64_t simulated = 0;  ///< ticks so far, those that came again too
};

/// A recording holds inputs and at most one state, its first. Snapshots taken on the way lie in
/// memory: going back loads the last one before the tick and simulates from there, as fast as the
/// machine can.
class ReplayLoop final : public VisitedWorld {
  public:
    ReplayLoop(const config::Settings& settings, std::string file, unsigned threads);
    ~ReplayLoop() override;

    /// Reads the file once. Fails where it begins neither with tick 1 nor with a state that can be
    /// loaded, or holds nothing.
    core::Result<bool> open();

    void start();
    void stop();

    /// From any thread; beyond the last tick: the last.
    void seek(Tick tick) { target_.store(std::min(std::max<Tick>(tick, before_ + 1), last_)); }

    [[nodiscard]] ReplayState state() const;

    bool visit(WorldVisit visit) override { return visits_.push(std::move(visit)); }

    void set_time_scale(double scale) override { time_scale_.store(scale); }

    [[nodiscard]] double time_scale() const override { return time_scale_.load(); }

    void step_ticks(unsigned ticks) override { steps_.fetch_add(ticks); }

    [[nodiscard]] std::shared_ptr<const LoopStats> published() const override {
        return published_.get();
    }

  private:
    void loop();

    /// The world at a tick that was here before.
    struct KeptState {
        Tick tick = 0;
        std::vector<std::uint8_t> bytes;
    };

    /// The world before the recording's first tick, and the file from there. Empty text: done.
    std::string begin_anew();
    /// The world of the last snapshot up to `target`, else before the first tick.
    void begin_before(Tick target);
    [[nodiscard]] const KeptState* kept_before(Tick target) const;
    void keep_state();
    void go_to(Tick target);
    void stand_still();
    void play(double scale);
    /// One tick; false: there is none any more.
    bool step(bool compare);
    void count();
    void publish();

    const config::Settings& settings_;
    std::string file_;
    unsigned threads_;
    Tick before_ = 0;  // the tick before the recording's first
    Tick last_ = 0;
    std::unique_ptr<World> world_;
    recording::RecordingReader reader_;
    recording::TickRecord record_;
    std::vector<KeptState> kept_;  // ascending
    std::size_t kept_bytes_ = 0;
    Tick keep_every_ = 1;
    double due_s_ = 0.0;
    double publish_due_s_ = 0.0;
    LoopStats figures_;
    mailbox::Latest<LoopStats> published_;
    VisitQueue visits_;
    std::atomic<double> time_scale_{1.0};
    std::atomic<unsigned> steps_{0};
    std::atomic<Tick> target_{0};
    std::atomic<Tick> tick_{0};
    std::atomic<std::uint64_t> simulated_{0};
    std::atomic<bool> stop_{false};
    mutable std::mutex mutex_;  // guards what follows
    std::string fault_;
    bool differs_ = false;
    std::thread thread_;
};

}  // namespace zoned::app
