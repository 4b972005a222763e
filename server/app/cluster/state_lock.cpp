#include "server/app/cluster/state_lock.h"

#include "server/session/login/secrets.h"

#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include <array>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <stdexcept>

namespace zoned::app {

namespace {

constexpr std::size_t kInstanceBytes = 16;

}  // namespace

StateLock::StateLock(const std::string& folder) {
    std::error_code ignored;
    std::filesystem::create_directories(folder, ignored);
    const std::string name = folder + "/cluster.instance";
    file_ = ::open(name.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0600);
    if (file_ < 0) {
        throw std::runtime_error("cannot write " + name + ": " + std::strerror(errno));
    }
    if (::flock(file_, LOCK_EX | LOCK_NB) != 0) {
        ::close(file_);
        throw std::runtime_error("another server uses the state folder " + folder +
                                 ": give each its own session.state_folder");
    }
    std::array<std::uint8_t, kInstanceBytes> bytes{};
    if (::pread(file_, bytes.data(), bytes.size(), 0) != static_cast<ssize_t>(bytes.size())) {
        session::random_bytes(bytes);
        if (::pwrite(file_, bytes.data(), bytes.size(), 0) != static_cast<ssize_t>(bytes.size())) {
            ::close(file_);
            throw std::runtime_error("cannot write " + name + ": " + std::strerror(errno));
        }
    }
    instance_.assign(bytes.begin(), bytes.end());
}

StateLock::~StateLock() {
    ::close(file_);
}

}  // namespace zoned::app
