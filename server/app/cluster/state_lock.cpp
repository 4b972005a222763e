#include "server/app/cluster/state_lock.h"

#include "server/app/log/log.h"
#include "server/session/login/secrets.h"

#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <chrono>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <stdexcept>
#include <thread>
#include <utility>

namespace zoned::app {

namespace {

constexpr std::size_t kInstanceBytes = 16;
constexpr auto kLockLookEvery = std::chrono::milliseconds(20);

}  // namespace

StateLock::StateLock(const std::string& folder, bool waits) {
    std::error_code ignored;
    std::filesystem::create_directories(folder, ignored);
    const std::string name = folder + "/cluster.instance";
    file_ = ::open(name.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0600);
    if (file_ < 0) {
        throw std::runtime_error("cannot write " + name + ": " + std::strerror(errno));
    }
    bool logged = false;
    while (::flock(file_, LOCK_EX | LOCK_NB) != 0) {
        if (waits && errno == EWOULDBLOCK) {
            if (!std::exchange(logged, true)) {
                log_of(LogArea::kCluster)
                    .info(
                        "another server uses the state folder {}; this server waits to take its "
                        "place",
                        folder);
            }
            std::this_thread::sleep_for(kLockLookEvery);
            continue;
        }
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
