// NameLookup: the address of a server by its name, at once or without waiting.
#pragma once

#include "shared/core/foreign_handle.h"
#include "shared/core/result.h"

#include <netinet/in.h>
#include <sys/socket.h>

#include <cstdint>
#include <optional>
#include <string>

namespace zoned::link {

/// An address of IPv4 or IPv6 with a port, as the system's calls take it.
struct SocketAddress {
    sockaddr_storage storage{};
    socklen_t size = 0;

    [[nodiscard]] bool is_v4() const { return storage.ss_family == AF_INET; }

    [[nodiscard]] bool is_loopback() const;
    void set_port(std::uint16_t port);

    [[nodiscard]] const sockaddr* get() const {
        return reinterpret_cast<const sockaddr*>(&storage);
    }
};

using Address = core::Result<SocketAddress>;

/// None where `host` is a name.
[[nodiscard]] std::optional<SocketAddress> parse_address(const std::string& host);

/// True for the addresses of this machine, and for the name localhost.
[[nodiscard]] bool is_loopback(const std::string& host);

/// Waits for a name server where `host` is a name: up to half a minute. Of several addresses an
/// IPv4 one is taken, as the server listens on both by default.
[[nodiscard]] Address look_up(const std::string& host, std::uint16_t port);

/// Looks up a name on a thread of its own, which may outlive this object: a name server that does
/// not answer holds nobody up.
class NameLookup {
  public:
    NameLookup(const std::string& host, std::uint16_t port);

    /// None while the answer is awaited.
    [[nodiscard]] std::optional<Address> answer() const;

  private:
    struct Shared;
    core::ForeignHandle shared_;
};

}  // namespace zoned::link
