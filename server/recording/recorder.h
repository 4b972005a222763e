// Recorder: writes and reads recordings, from which `zoned replay` re-simulates a run bit for bit.
#pragma once

#include "server/mailbox/messages.h"
#include "shared/core/ids.h"
#include "shared/core/result.h"

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

namespace zoned::recording {

/// Version of the simulation. Raise it with every change after which the same input gives other
/// hashes.
inline constexpr std::uint32_t kSimulationGeneration = 11;
/// Version of the file format.
inline constexpr std::uint32_t kRecordingFormat = 1;

/// The header of a recording: the run that it comes from.
struct RecordingHeader {
    std::uint32_t generation = kSimulationGeneration;
    std::string target;    ///< processor target of the build
    std::string compiler;  ///< for information
    std::string config_text;
    std::string config_digest;
    std::uint64_t seed = 0;

    /// Target, compiler and generation of this program.
    static RecordingHeader of_this_build();
};

/// The input of one zone at a tick, and the hash of its state after it.
struct ZoneTick {
    ZoneId zone;
    std::vector<mailbox::InboxItem> inbox;
    std::uint64_t hash = 0;
};

struct TickRecord {
    Tick tick = 0;
    std::vector<ZoneTick> zones;
};

/// The file: 8 bytes of magic, then frames: length (4 bytes, little endian), checksum of the
/// payload (8 bytes), payload (a RecordingFrame). Writes are buffered. Not thread-safe.
class RecordingWriter {
  public:
    RecordingWriter();
    RecordingWriter(RecordingWriter&&) noexcept;
    RecordingWriter& operator=(RecordingWriter&&) noexcept;
    ~RecordingWriter();  ///< closes without an end mark when close() was not called

    /// Replaces an existing file.
    core::Result<bool> open(const std::string& file, const RecordingHeader& header);
    /// Ticks ascend. A failed write sticks: nothing more is written, close() tells the reason.
    void add_tick(Tick tick, std::span<const ZoneTick> zones);
    /// Writes the end mark; fails with the first thing that went wrong since open().
    core::Result<bool> close();

    [[nodiscard]] std::uint64_t bytes() const;

  private:
    struct Impl;
    std::unique_ptr<Impl> impl_;
};

/// Reads a recording from its beginning to its end. Not thread-safe.
class RecordingReader {
  public:
    RecordingReader();
    RecordingReader(RecordingReader&&) noexcept;
    RecordingReader& operator=(RecordingReader&&) noexcept;
    ~RecordingReader();

    /// Fails with a reason when the file cannot be read, is no recording, has another format, or
    /// was made by a build whose hashes need not agree with this one's (target, generation).
    core::Result<bool> open(const std::string& file);
    [[nodiscard]] const RecordingHeader& header() const;
    /// True: `record` holds the next tick. False: the recording ended in good order. Fails on
    /// damage, and where the file ends without its end mark.
    core::Result<bool> next(TickRecord& record);

  private:
    struct Impl;
    std::unique_ptr<Impl> impl_;
};

}  // namespace zoned::recording
