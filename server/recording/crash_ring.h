// CrashRing: the last seconds of a run's inputs on disk, in pieces of which the oldest go.
#pragma once

#include "server/recording/recording_file.h"

#include <cstdint>
#include <deque>
#include <string>
#include <string_view>

namespace zoned::recording {

/// Pieces of a recording in a folder; together they hold at least the ticks asked for. A run that
/// ends in good order removes them: pieces that a start finds come from a run that did not. Such a
/// folder is kept under a name with its time, the newest three of them. Not thread-safe.
class CrashRing {
  public:
    CrashRing() = default;
    CrashRing(const CrashRing&) = delete;
    CrashRing& operator=(const CrashRing&) = delete;
    ~CrashRing();  ///< leaves the pieces

    /// `ticks`: at least 1. Fails where the folder cannot be made, or another process writes there.
    core::Result<bool> open(const std::string& folder,
                            std::uint64_t ticks,
                            const RecordingHeader& header);
    /// As RecordingFile::append(). A failed write sticks until the next piece is due.
    void append(std::string_view frame, Tick tick, bool begins_tick);
    void flush();
    /// What was kept is of no use after a gap in the ticks: begins anew.
    void restart();
    /// Removes the pieces, or leaves them for the next start.
    void close(bool keeps);

    [[nodiscard]] bool is_open() const { return lock_ >= 0; }

    /// The folder that holds the inputs of an earlier run that did not end well; empty: none.
    [[nodiscard]] const std::string& kept() const { return kept_; }

    /// The oldest tick that a piece begins with; 0: there is none.
    [[nodiscard]] Tick first_tick() const;

    /// Why the present piece is not written; empty: all is well.
    [[nodiscard]] const std::string& error() const { return piece_.error(); }

  private:
    void begin_piece(Tick tick);
    void keep_old();

    std::string folder_;
    std::string kept_;
    RecordingHeader header_;
    std::uint64_t piece_ticks_ = 1;
    std::uint64_t ticks_ = 0;  ///< of the piece
    RecordingFile piece_;

    struct Piece {
        Tick first = 0;
        std::string file;
    };

    std::deque<Piece> pieces_;
    int lock_ = -1;
};

}  // namespace zoned::recording
