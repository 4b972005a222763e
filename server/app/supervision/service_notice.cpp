#include "server/app/supervision/service_notice.h"

#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <cstddef>
#include <cstdlib>
#include <cstring>

namespace zoned::app {

namespace {

std::string environment(const char* name) {
    const char* value = std::getenv(name);
    return value == nullptr ? "" : value;
}

/// A path, or an abstract name that begins with '@'. Empty: no such address.
std::string unix_address(const std::string& name) {
    sockaddr_un address{};
    if (name.size() < 2 || name.size() >= sizeof(address.sun_path) ||
        (name[0] != '/' && name[0] != '@')) {
        return {};
    }
    address.sun_family = AF_UNIX;
    std::memcpy(address.sun_path, name.data(), name.size());
    const bool abstract = name[0] == '@';
    if (abstract) {
        address.sun_path[0] = '\0';
    }
    const std::size_t bytes = offsetof(sockaddr_un, sun_path) + name.size() + (abstract ? 0U : 1U);
    return {reinterpret_cast<const char*>(&address), bytes};
}

/// None: not for this process, or no positive number.
std::optional<double> asked_watchdog_s() {
    const std::string pid = environment("WATCHDOG_PID");
    const std::string usec = environment("WATCHDOG_USEC");
    char* end = nullptr;
    const unsigned long long us = std::strtoull(usec.c_str(), &end, 10);
    if (usec.empty() || *end != '\0' || us == 0 ||
        (!pid.empty() && pid != std::to_string(::getpid()))) {
        return std::nullopt;
    }
    return 1e-6 * static_cast<double>(us);
}

}  // namespace

ServiceNotice::ServiceNotice() : address_(unix_address(environment("NOTIFY_SOCKET"))) {
    if (!address_.empty()) {
        fd_ = ::socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC, 0);
        watchdog_s_ = asked_watchdog_s();
    }
    ::unsetenv("NOTIFY_SOCKET");
}

ServiceNotice::~ServiceNotice() {
    if (fd_ >= 0) {
        ::close(fd_);
    }
}

bool ServiceNotice::send(const std::string& message) {
    if (fd_ < 0) {
        return false;
    }
    sockaddr_un address{};
    std::memcpy(&address, address_.data(), address_.size());
    return ::sendto(fd_,
                    message.data(),
                    message.size(),
                    MSG_NOSIGNAL | MSG_DONTWAIT,
                    reinterpret_cast<const sockaddr*>(&address),
                    static_cast<socklen_t>(address_.size())) ==
           static_cast<ssize_t>(message.size());
}

}  // namespace zoned::app
