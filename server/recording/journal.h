// Journal: the inputs of all ticks since the last snapshot, on disk before anybody hears what came
// of them.
#pragma once

#include "server/recording/recording_file.h"
#include "shared/core/result.h"

#include <cstdint>
#include <deque>
#include <string>
#include <string_view>

namespace zoned::recording {

/// Pieces of a recording in a folder, as CrashRing has them; a new piece begins with each snapshot,
/// and those from before the snapshot go when it is on disk. Not thread-safe.
class Journal {
  public:
    Journal() = default;
    Journal(const Journal&) = delete;
    Journal& operator=(const Journal&) = delete;

    /// Into an existing folder. Pieces that lie there belong to an earlier snapshot: the first
    /// forget() removes them too.
    core::Result<bool> open(const std::string& folder, const RecordingHeader& header);
    /// As RecordingFile::append(). A failed write sticks until the next piece begins.
    void append(std::string_view frame, Tick tick, bool begins_tick);
    /// All that was appended outlives this process from here on, with `power` a cut of the
    /// machine's power too, or error() says why not.
    void sync(bool power);

    /// A piece of its own begins with the next tick.
    void cut() { cut_ = true; }

    /// The next tick begins a piece: that the present one failed matters no more.
    [[nodiscard]] bool is_cut() const { return cut_; }

    /// Removes all pieces that hold no tick after this one.
    void forget(Tick through);
    /// A gap in the ticks: nothing that follows can be replayed before the next cut().
    void give_up(const std::string& why);

    [[nodiscard]] bool is_open() const { return !folder_.empty(); }

    /// Why the present piece is not written; empty: all is well.
    [[nodiscard]] const std::string& error() const {
        return open_error_.empty() ? piece_.error() : open_error_;
    }

  private:
    void begin_piece(Tick tick);

    struct JournalPiece {
        Tick first = 0;
        std::string file;
    };

    std::string folder_;
    RecordingHeader header_;
    RecordingFile piece_;
    std::string open_error_;
    std::deque<JournalPiece> pieces_;  // ascending
    Tick newest_ = 0;
    bool cut_ = true;
};

}  // namespace zoned::recording
