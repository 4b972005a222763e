// Ledger: a sandbox client's own count of the decisions that it received: deaths, kills, trades,
// items.
#pragma once

#include "shared/core/ids.h"
#include "shared/wire/session/session_messages.h"

#include <cstdint>
#include <string>
#include <vector>

namespace zoned::bot {

class Ledger {
  public:
    /// Applies an event. True when `answer` is the payload of a COMMAND_AGREE to be sent.
    bool apply(const wire::EventMessage& event, EntityId avatar, std::string& answer);

    void clear() { *this = {}; }

    [[nodiscard]] std::uint32_t deaths() const { return deaths_; }

    [[nodiscard]] std::uint32_t kills() const { return kills_; }

    [[nodiscard]] std::uint32_t trades() const { return trades_; }

    [[nodiscard]] const std::vector<std::uint32_t>& items() const { return items_; }

    /// Times that the server's ledger differed from the sum of the decisions received.
    [[nodiscard]] std::uint64_t diverged() const { return diverged_; }

  private:
    [[nodiscard]] std::uint64_t digest() const;
    bool compare(const wire::EventMessage& event, std::string& answer);

    std::uint32_t deaths_ = 0;
    std::uint32_t kills_ = 0;
    std::uint32_t trades_ = 0;
    std::vector<std::uint32_t> items_;
    std::uint64_t diverged_ = 0;
};

}  // namespace zoned::bot
