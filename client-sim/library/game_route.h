// GameRoute: how the session of a game reaches its server.
#pragma once

#include "client-sim/link/link.h"

#include <string>

namespace zoned::library {

class GameRoute {
  public:
    virtual ~GameRoute() = default;

    [[nodiscard]] virtual link::Transport& transport() = 0;
    /// Why there is no way; empty: there may be one.
    [[nodiscard]] virtual const std::string& trouble() const = 0;

    /// Takes what has arrived.
    virtual void poll(double now_s) = 0;
    /// Sends what waits.
    virtual void flush() = 0;
};

}  // namespace zoned::library
