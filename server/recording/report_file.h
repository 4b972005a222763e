// ReportFile: a place for a report that is made sure of beforehand, and filled all or nothing.
#pragma once

#include "shared/core/result.h"

#include <string>
#include <string_view>

namespace zoned::recording {

/// Reserves space beside the file, so that a report comes to disk even where a recording has filled
/// it meanwhile. commit() writes, syncs and renames: readers see the old file or the whole new one.
/// Devices and pipes are written as they are.
class ReportFile {
  public:
    ReportFile() = default;
    ReportFile(const ReportFile&) = delete;
    ReportFile& operator=(const ReportFile&) = delete;
    ~ReportFile();  ///< without commit() the file stays as it was

    /// Fails with a reason where the file could not be written later.
    core::Result<bool> reserve(const std::string& file);
    core::Result<bool> commit(std::string_view text);

  private:
    [[nodiscard]] core::Result<bool> failure() const;

    std::string file_;
    std::string part_;  ///< empty: `file_` is written directly
    int fd_ = -1;
};

}  // namespace zoned::recording
