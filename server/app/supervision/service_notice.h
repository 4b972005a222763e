// ServiceNotice: tells systemd how the service is, by its notification protocol (sd_notify(3)).
#pragma once

#include <optional>
#include <string>

namespace zoned::app {

/// Datagrams to the socket that NOTIFY_SOCKET names; nothing where the variable is not set. Not
/// thread-safe.
class ServiceNotice {
  public:
    /// Reads the environment, and takes NOTIFY_SOCKET out of it: children of ours do not speak for
    /// us.
    ServiceNotice();
    ServiceNotice(const ServiceNotice&) = delete;
    ServiceNotice& operator=(const ServiceNotice&) = delete;
    ~ServiceNotice();

    /// False when nobody listens or the message could not be sent. `message`: lines NAME=VALUE.
    bool send(const std::string& message);

    /// Seconds within which systemd wants WATCHDOG=1; none: it does not ask.
    [[nodiscard]] std::optional<double> watchdog_s() const { return watchdog_s_; }

  private:
    int fd_ = -1;
    std::string address_;  ///< bytes of a sockaddr_un
    std::optional<double> watchdog_s_;
};

}  // namespace zoned::app
