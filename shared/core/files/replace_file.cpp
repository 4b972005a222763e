#include "shared/core/files/replace_file.h"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <filesystem>

namespace zoned::core {

bool write_whole(int fd, std::string_view bytes) {
    while (!bytes.empty()) {
        const ssize_t n = ::write(fd, bytes.data(), bytes.size());
        if (n < 0 && errno == EINTR) {
            continue;
        }
        if (n <= 0) {
            return false;
        }
        bytes.remove_prefix(static_cast<std::size_t>(n));
    }
    return true;
}

void sync_folder(const std::string& folder) {
    const int fd =
        ::open(folder.empty() ? "." : folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
    if (fd >= 0) {
        ::fsync(fd);
        ::close(fd);
    }
}

Result<bool> replace_file(const std::string& path, std::string_view bytes, unsigned mode) {
    const std::string part = path + ".part";
    ::unlink(part.c_str());  // left by a crash; nobody's link is written through
    const int fd = ::open(part.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, mode);
    bool good = fd >= 0 && write_whole(fd, bytes) && ::fsync(fd) == 0;
    int why = errno;
    if (fd >= 0) {
        ::close(fd);
    }
    if (good && std::rename(part.c_str(), path.c_str()) != 0) {
        good = false;
        why = errno;
    }
    if (!good) {
        ::unlink(part.c_str());
        return Result<bool>::failure("cannot write '" + path + "': " + std::strerror(why));
    }
    sync_folder(std::filesystem::path(path).parent_path().string());
    return true;
}

}  // namespace zoned::core
