// Replacing a file all or nothing.
#pragma once

#include "shared/core/result.h"

#include <string>
#include <string_view>

namespace zoned::core {

/// Writes all bytes to an open file. False: `errno` says why.
bool write_whole(int fd, std::string_view bytes);

/// A name is on disk once its folder is: makes the names in `folder` ("" is the current one) last.
/// Does nothing where the folder cannot be opened.
void sync_folder(const std::string& folder);

/// Writes beside the file, waits for the disk and renames: readers and crashes find the old file or
/// the whole new one. `mode`: of open(2). Fails with path and reason, and leaves the old file then.
Result<bool> replace_file(const std::string& path, std::string_view bytes, unsigned mode);

}  // namespace zoned::core
