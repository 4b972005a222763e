#include "server/recording/report_file.h"

#include "shared/core/files/replace_file.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <utility>

namespace zoned::recording {

namespace {

using core::Result;

/// More than the report of a world with hundreds of zones takes.
constexpr off_t kReservedBytes = 256 << 10;

}  // namespace

ReportFile::~ReportFile() {
    if (fd_ >= 0) {
        ::close(fd_);
        if (!part_.empty()) {
            ::unlink(part_.c_str());
        }
    }
}

Result<bool> ReportFile::failure() const {
    return Result<bool>::failure("cannot write the report '" + file_ +
                                 "': " + std::strerror(errno));
}

Result<bool> ReportFile::reserve(const std::string& file) {
    file_ = file;

    struct stat info {};

    const bool special = ::stat(file.c_str(), &info) == 0 && !S_ISREG(info.st_mode);
    if (special) {
        fd_ = ::open(file.c_str(), O_WRONLY | O_CLOEXEC);
        return fd_ >= 0 ? Result<bool>(true) : failure();
    }
    part_ = file + ".part";
    fd_ = ::open(part_.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0644);
    if (fd_ < 0) {
        return failure();
    }
    const int error = ::posix_fallocate(fd_, 0, kReservedBytes);
    if (error != 0 && error != EOPNOTSUPP && error != EINVAL) {
        errno = error;
        return failure();
    }
    return true;
}

Result<bool> ReportFile::commit(std::string_view text) {
    if (fd_ < 0) {
        return Result<bool>::failure("no report is open");
    }
    if (!core::write_whole(fd_, text)) {
        return failure();
    }
    if (part_.empty()) {
        ::close(std::exchange(fd_, -1));
        return true;
    }
    // The reserved bytes behind the text go; what stays is on disk before it gets its name.
    if (::ftruncate(fd_, static_cast<off_t>(text.size())) != 0 || ::fsync(fd_) != 0) {
        return failure();
    }
    ::close(std::exchange(fd_, -1));
    if (std::rename(part_.c_str(), file_.c_str()) != 0) {
        return failure();
    }
    core::sync_folder(std::filesystem::path(file_).parent_path().string());
    return true;
}

}  // namespace zoned::recording
