// CrashRing: the last seconds of a run's inputs on disk, in pieces of which the oldest go.
#pragma once

#include "server/recording/recording_file.h"

#include <cstdint>
#include <deque>
#include <string>
#include <string_view>

namespace zoned::recording {

/// The file for the state of a tick beside the pieces of a ring. Its name sorts directly before
/// that of the piece that begins with the next tick.
std::string ring_state_file(const std::string& folder, Tick tick);

/// Whether a file is one by its name.
bool is_ring_state(const std::string& file);

/// Pieces of a recording in a folder; together they hold at least the ticks asked for. States may
/// stand beside them, written by somebody else (ring_state_file()): the pieces then go back to the
/// older of two states. A run that ends in good order removes all of them: pieces that a start
/// finds come from a run that did not. Such a folder is kept under a name with its time, the newest
/// three of them. Not thread-safe.
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

    /// A piece of its own begins with the next tick.
    void cut() { ticks_ = piece_ticks_; }

    /// A state of this tick is there, and perhaps later ones: older states go, and older pieces
    /// where there are enough of them.
    void keep_from(Tick state);

    /// What was kept is of no use after a gap in the ticks: begins anew.
    void restart();
    /// Removes the pieces, or leaves them for the next start.
    void close(bool keeps);

    [[nodiscard]] bool is_open() const { return lock_ >= 0; }

    /// The folder that holds the inputs of an earlier run that did not end well; empty: none.
    [[nodiscard]] const std::string& kept() const { return kept_; }

    /// From tick 1 or from a state on.
    [[nodiscard]] bool can_be_replayed() const {
        return lock_ >= 0 && (state_ > 0 || (!pieces_.empty() && pieces_.front().first == 1));
    }

    /// Why the present piece is not written; empty: all is well.
    [[nodiscard]] const std::string& error() const { return piece_.error(); }

  private:
    void begin_piece(Tick tick);
    void remove_old_pieces(Tick tick);
    void remove_states_before(Tick tick);
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
    Tick state_ = 0;  // of the oldest state that counts; 0: none
    int lock_ = -1;
};

}  // namespace zoned::recording
