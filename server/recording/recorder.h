// Recorder: writes what enters the world to disk, on a thread of its own, so that `zoned replay`
// simulates the run again bit for bit.
#pragma once

#include "server/recording/crash_ring.h"
#include "server/recording/journal.h"
#include "server/recording/recording_file.h"

#include <semaphore.h>

#include <atomic>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <span>
#include <string>
#include <thread>
#include <vector>

namespace zoned::recording {

/// What the world is given before a tick.
using Inputs = std::vector<mailbox::InboxItem>;

struct RecorderSettings {
    std::string file;         ///< the whole run; empty: none
    RecordedState begins;     ///< what the file begins with; of tick 0: with tick 1
    std::string ring_folder;  ///< of the last seconds
    double ring_s = 0.0;      ///< 0: no ring
    double rate_hz = 30.0;    ///< ticks a second
    RecordingHeader header;
    std::string journal_folder;     ///< all inputs since the last snapshot; empty: none
    bool journal_for_power = true;  ///< what is kept survives the loss of power
    /// The inputs up to this tick are kept, on the writer's thread. Called for all ticks in their
    /// order: a disk that fails, or is ten seconds behind, holds nobody up.
    std::function<void(Tick)> kept = {};
};

/// The result of an operator's wish as a text, or why it came to nothing; called on a thread of the
/// recorder's.
using RecordingAnswer = std::function<void(const core::Result<std::string>&)>;

struct RecorderFigures {
    std::uint64_t ticks = 0;     ///< taken by the writer
    std::uint64_t bytes = 0;     ///< of the file
    std::uint64_t failures = 0;  ///< 0 or 1 of the file, and of pieces of the ring
    std::uint64_t behind_ticks_max = 0;
    std::uint64_t writer_cpu_ns = 0;
};

/// The tick loop calls begin_tick() and end_tick() and never waits for a disk; all encoding and
/// writing is done by a thread of the recorder. Inputs are with the system within a tenth of a
/// second, and before a crash that has a handler ends the process; those of a journal at once. To
/// wake a thread for each tick costs as much as what it writes. A disk that is full, fails or stays
/// ten seconds behind ends the recording of the file with one message; play goes on.
class Recorder {
  public:
    /// `tell` hears each failure once, at once, on the writer's thread.
    Recorder(RecorderSettings settings, std::function<void(const std::string&)> tell);
    Recorder(const Recorder&) = delete;
    Recorder& operator=(const Recorder&) = delete;
    ~Recorder();  ///< without close(): as when the process dies

    /// Fails when the file cannot be created. A ring that cannot be kept is told of, no more.
    core::Result<bool> open();

    /// An empty vector for the inputs of a tick, with memory of an earlier tick.
    std::shared_ptr<Inputs> lend();
    /// Before the tick is simulated. Nobody changes the inputs from here on.
    void begin_tick(Tick tick, std::shared_ptr<const Inputs> inputs);
    /// After it, with the state hash of each zone.
    void end_tick(Tick tick, std::vector<std::uint64_t> hashes);

    /// Between two ticks, with that of a snapshot that is being taken.
    void cut_journal(Tick last);
    /// The snapshot of this tick is on disk: older inputs are of no use. From any thread.
    void forget_journal(Tick through);

    /// Between two ticks, with that of a state that is being written beside the ring.
    void cut_ring(Tick last);
    /// States of this tick and later are beside the ring: older inputs are of no use.
    void keep_ring_from(Tick state);

    // Wishes of an operator, from any thread; carried out between two ticks.

    /// Ends the recording of the file in good order; the ring goes on.
    void stop_file(RecordingAnswer answer);
    /// On the tick loop's thread between two ticks: begins a file that does not exist yet with the
    /// state that the world has now.
    void start_file(std::string file, RecordedState state, RecordingAnswer answer);
    /// Writes what is recorded up to now into a file of its own, that does not exist yet, whole or
    /// not at all; where nothing is recorded, the whole run, if the ring holds it.
    void snapshot(std::string file, RecordingAnswer answer);

    /// Ends both recordings: the file gets its end mark, the ring goes, unless it is wanted for the
    /// fault that ended the run. Fails with what went wrong with the file, at any time.
    core::Result<bool> close(bool keeps_ring = false);

    /// A crash from here on would bring back all that `kept` told of. False from a failure of the
    /// journal until a snapshot after it is on disk. From any thread.
    [[nodiscard]] bool journal_is_whole() const { return journal_gap_ == JournalGap::kNone; }

    /// From any thread.
    [[nodiscard]] RecorderFigures figures() const;

    /// The ring is this process's own, from open() to close().
    [[nodiscard]] bool keeps_ring() const { return ring_.is_open(); }

    /// The folder with the last inputs of an earlier run that did not end well; empty: none.
    [[nodiscard]] const std::string& kept_ring() const { return ring_.kept(); }

  private:
    struct Beginning {
        std::string file;
        RecordedState state;
        RecordingAnswer answer;
    };

    enum class Upkeep : std::uint8_t {
        kNone,
        kCutJournal,     ///< before the next tick
        kForgetJournal,  ///< what it holds up to this tick
        kCutRing,        ///< as the journal
        kKeepRing        ///< from the state of this tick on
    };

    enum class JournalGap : std::uint8_t {
        kNone,
        kFailed,
        kCut,  ///< written again since, for a snapshot that is not on disk yet
    };

    struct Entry {
        Tick tick = 0;
        std::shared_ptr<const Inputs> inputs;  ///< null: hashes
        std::vector<std::uint64_t> hashes;
        Upkeep upkeep = Upkeep::kNone;            ///< in place of inputs and hashes
        std::shared_ptr<const Beginning> begins;  ///< a file, before the next tick
    };

    struct Pool;

    enum class Wish : std::uint8_t {
        kStop,
        kSnapshot
    };

    struct Order {
        Wish wish = Wish::kStop;
        std::string file;
        RecordingAnswer answer;
    };

    /// False: the writer is too far behind, nothing is written any more.
    bool push(Entry entry, bool wake);
    void run();
    /// Until there is something that cannot wait, a tenth of a second at most.
    void rest();
    void write_all(const std::vector<Entry>& entries, std::vector<Order>& orders);
    void write(const Entry& entry);
    void sync_journal();
    void keep(const std::vector<Entry>& entries);
    // recorder_orders.cpp
    void order(Wish wish, std::string file, RecordingAnswer answer);
    void carry_out(std::vector<Order>& orders);
    core::Result<std::string> end_file();
    core::Result<std::string> begin_file(const Beginning& beginning);
    /// Answers at once or from `copier_`.
    void copy_run(const Order& order);
    void fall_behind();
    void look_for_failures();

    RecorderSettings settings_;
    std::function<void(const std::string&)> tell_;
    RecordingFile file_;  // of the writer's thread, from open() to close()
    CrashRing ring_;
    std::atomic<JournalGap> journal_gap_{JournalGap::kNone};
    Journal journal_;
    FrameEncoder encoder_;
    Tick whole_tick_ = 0;       // the last one with hashes
    Tick before_file_ = 0;      // the tick before the file's first one
    bool within_tick_ = false;  // its inputs are written, its hashes are not
    std::thread copier_;
    std::atomic<bool> copies_{false};
    bool file_failure_logged_ = false;
    bool ring_failure_logged_ = false;
    bool journal_failure_logged_ = false;
    std::shared_ptr<Pool> pool_;
    std::size_t most_entries_ = 0;

    sem_t bell_{};              // wakes the writer; a handler of signals may ring it
    mutable std::mutex mutex_;  // guards what follows
    std::vector<Entry> entries_;
    std::vector<Order> orders_;
    bool orders_wait_ = false;  ///< for the end of a tick
    bool overflowed_ = false;
    bool closing_ = false;
    RecorderFigures figures_;

    std::thread thread_;
};

/// For a handler of crashes: wakes the writer, and waits until the inputs that were begun last are
/// on their way to disk, `most_ms` at most. Async-signal-safe.
void await_written_inputs(int most_ms) noexcept;

}  // namespace zoned::recording
