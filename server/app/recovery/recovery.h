// Recovery: brings a world back to the tick at which its server died, and keeps on disk what that
// takes: a snapshot now and then, and the inputs since (recording/journal.h).
#pragma once

#include "server/app/recovery/process_copy.h"
#include "server/app/recovery/run_ledger.h"
#include "server/app/recovery/snapshot_file.h"
#include "server/app/world/world.h"
#include "server/config/settings.h"
#include "server/recording/recorder.h"

#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace zoned::app {

/// The run before this one, as a start found it.
struct RecoveredRun {
    Tick tick = 0;         ///< the world stands after it; 0: it begins anew
    Tick snapshot = 0;     ///< of the snapshot that was loaded
    double seconds = 0.0;  ///< that it took
    std::size_t sessions = 0;
    std::uint64_t recoveries = 0;  ///< of this world up to this one, since it began anew
    std::string text;              ///< for the log
    std::string trouble;           ///< what is not as it was; empty: all is
};

struct SnapshotFigures {
    std::uint64_t taken = 0;
    std::uint64_t failed = 0;
};

/// A snapshot is taken by a copy of the process: the ticks go on meanwhile. The state between two
/// ticks and the inputs after it give the same world again, bit for bit.
class Recovery {
  public:
    /// Takes the folder `journal` in the state folder for this process. Throws std::runtime_error
    /// when another server has it.
    explicit Recovery(const config::Settings& settings);
    Recovery(const Recovery&) = delete;
    Recovery& operator=(const Recovery&) = delete;
    ~Recovery();

    /// Before the first tick. Into a world before its first tick goes what a server left that died,
    /// if one did; from there on the world can be brought back. Throws std::runtime_error that says
    /// what to do. `life` is that of the world by the word of its cluster, empty without one: what
    /// lies there of another life is set aside, as a server had the world since.
    RecoveredRun begin(World& world, const std::string& life);

    /// The start is refused after begin(): that is no death, however often somebody tries.
    void refused() const;

    /// Sessions and requests as they were in the last tick.
    [[nodiscard]] RunLedger& ledger() { return ledger_; }

    [[nodiscard]] const std::string& folder() const { return folder_; }

    /// After each tick, on the loop's thread, before anybody hears of its output. Adds to it which
    /// commands are kept when the tick's inputs are.
    void after_tick(World& world,
                    std::span<const mailbox::InboxItem> in,
                    std::vector<mailbox::OutboxItem>& out,
                    recording::Recorder& recorder);

    /// After the last tick of a run that ends in good order, when the recorder is closed. Empty
    /// text: done.
    std::string end(const World& world);

    /// On the loop's thread, or when it has stopped.
    [[nodiscard]] const SnapshotFigures& figures() const { return figures_; }

    /// How long the tick loop waited for each snapshot, ms.
    [[nodiscard]] const core::Histogram& pauses_ms() const { return copy_.pauses_ms(); }

  private:
    void lock();
    void go_on(World& world, RecoveredRun& run);
    void set_aside(const std::string& why);
    void load(World& world, RecoveredRun& run);
    void replay(World& world, bool leaves_out_last, RecoveredRun& run);
    void keep_state(const World& world);
    void take_snapshot(const World& world, recording::Recorder& recorder);
    void look_after_copy(recording::Recorder& recorder);

    const config::Settings& settings_;
    std::string folder_;
    int lock_ = -1;
    unsigned attempts_ = 0;  // starts in a row that tried to go on, with this one
    Tick every_ticks_ = 1;
    Tick lives_ticks_ = 1;  // a start that comes so far is no vain attempt
    Tick begun_ = 0;        // the world's tick at the start
    RunLedger ledger_;
    Tick last_ = 0;     // of the newest snapshot that is on disk
    Tick before_ = 0;   // of the one before it
    Tick started_ = 0;  // of the one that is being written
    ProcessCopy copy_;  // writes it
    SnapshotFigures figures_;
};

}  // namespace zoned::app
