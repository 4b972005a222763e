// NameLookup: the address of a server by its name, at once or without waiting.
#pragma once

// clang-format off
#include <coroutine>  // before asio, which clang++ needs to find its coroutines
#include <asio.hpp>
// clang-format on

#include "shared/core/result.h"

#include <memory>
#include <optional>
#include <string>

namespace zoned::link {

using Address = core::Result<asio::ip::tcp::endpoint>;

/// True for the addresses of this machine, and for the name localhost.
[[nodiscard]] bool is_loopback(const std::string& host);

/// Waits for a name server where `host` is a name: up to half a minute. Of several addresses an
/// IPv4 one is taken, as the server listens on both by default.
[[nodiscard]] Address look_up(const std::string& host, const std::string& port);

/// Looks up a name on a thread of its own, which may outlive this object: a name server that does
/// not answer holds nobody up. An address is known at once, without a thread.
class NameLookup {
  public:
    NameLookup(const std::string& host, const std::string& port);

    /// None while the answer is awaited.
    [[nodiscard]] std::optional<Address> answer() const;

  private:
    struct Shared;
    std::shared_ptr<Shared> shared_;
};

}  // namespace zoned::link
