// RecordingFile: writes a recording frame by frame; what is on disk always ends with a whole frame.
#pragma once

#include "server/recording/recording_format.h"
#include "shared/core/result.h"

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <string_view>

namespace zoned::recording {

/// Encodes frames; keeps its memory from tick to tick. Not thread-safe.
class FrameEncoder {
  public:
    FrameEncoder();
    ~FrameEncoder();

    /// Each call gives one frame, valid until the next; empty: it would be too large for a reader.
    std::string_view header(const RecordingHeader& header);
    std::string_view inputs(Tick tick, std::span<const mailbox::InboxItem> items);
    std::string_view hashes(Tick tick, std::span<const std::uint64_t> hashes);
    std::string_view end(std::uint64_t ticks);
    std::string_view state(const RecordedState& state);

  private:
    struct Impl;
    std::unique_ptr<Impl> impl_;
};

/// A file that grows by whole frames. A failed write sticks: the part of a frame that came to the
/// disk is cut off again, and nothing more is written. Not thread-safe.
class RecordingFile {
  public:
    RecordingFile() = default;
    RecordingFile(RecordingFile&& other) noexcept;
    RecordingFile& operator=(RecordingFile&& other) noexcept;
    ~RecordingFile();  ///< flushes; without close() the file has no end mark

    /// Replaces an existing file; writes the header at once.
    /// `state`, where not null, is where the recording begins.
    core::Result<bool> open(const std::string& file,
                            const RecordingHeader& header,
                            const RecordedState* state = nullptr);
    /// Appends an encoded frame of inputs or hashes, buffered until flush() or a MiB is full.
    void append(std::string_view frame, bool begins_tick);
    /// What was appended is the system's from here on, and survives the death of this process.
    void flush();
    /// The same, and it survives the loss of the machine's power.
    void sync();
    /// Nothing more is written, for a reason of the caller's.
    void give_up(const std::string& reason);
    /// Encodes and appends a tick.
    void add_tick(const TickRecord& record);
    /// Writes the end mark; fails with the first thing that went wrong since open().
    core::Result<bool> close();

    [[nodiscard]] bool is_open() const { return fd_ >= 0; }

    [[nodiscard]] const std::string& name() const { return name_; }

    /// Why it does not write any more; empty: all is well.
    [[nodiscard]] const std::string& error() const { return error_; }

    [[nodiscard]] std::uint64_t bytes() const { return written_; }

  private:
    void fail(const std::string& reason);
    void shut();

    int fd_ = -1;
    std::string name_;
    std::string error_;
    std::string buffer_;
    std::uint64_t written_ = 0;
    std::uint64_t ticks_ = 0;
};

}  // namespace zoned::recording
