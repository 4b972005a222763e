// RecordingReader: reads a recording up to its end or its first damage, and says where that is.
#pragma once

#include "server/recording/recording_format.h"
#include "shared/core/result.h"

#include <cstdint>
#include <memory>
#include <optional>
#include <string>

namespace zoned::recording {

/// Reads a file, or a folder with the pieces of one (CrashRing): from its first tick where that is
/// tick 1, else from the oldest state in it, else from its first piece. Not thread-safe.
class RecordingReader {
  public:
    RecordingReader();
    RecordingReader(RecordingReader&&) noexcept;
    RecordingReader& operator=(RecordingReader&&) noexcept;
    ~RecordingReader();

    /// Fails with a reason when nothing can be read, it is no recording, it has another format, or
    /// the state that it begins with is damaged.
    core::Result<bool> open(const std::string& path);
    [[nodiscard]] const RecordingHeader& header() const;
    /// The world's state before the first tick; none: it was not kept, or the first is tick 1.
    [[nodiscard]] const std::optional<RecordedState>& state() const;
    /// Fails with both versions named where hashes of this build need not agree with the recorded
    /// ones: the simulation's generation differs. Processors and compilers agree.
    [[nodiscard]] core::Result<bool> check_build() const;
    /// Goes on to the first tick that is not before `tick`, by the heads of frames alone. True:
    /// there is one. It does not go back.
    core::Result<bool> seek(Tick tick);
    /// True: `record` holds the next tick. False: the recording ended in good order. Fails on
    /// damage, and where the last file ends without its end mark; the reason names the byte and the
    /// last whole tick. All ticks before the damage have been given by then.
    core::Result<bool> next(TickRecord& record);

    /// Of all files.
    [[nodiscard]] std::uint64_t bytes() const;

  private:
    struct Impl;
    std::unique_ptr<Impl> impl_;
};

}  // namespace zoned::recording
