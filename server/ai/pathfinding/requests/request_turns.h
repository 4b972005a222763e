// RequestTurns: who waits for a path, whose turn it is, and how many have to be served in a tick.
#pragma once

#include "server/ai/pathfinding/requests/saved_paths.h"

#include <cstdint>
#include <vector>

namespace zoned::ai::pathfinding {

/// First come, first served among askers; who asks for several at once waits for each in turn, so
/// that nobody waits longer for another's many. Requests are small numbers; so are askers.
/// Allocates only where one is larger than any before.
class RequestTurns {
  public:
    static constexpr std::uint32_t kNone = ~0U;

    /// `wait` ticks is the longest that an asker's turn may take to come.
    explicit RequestTurns(std::uint32_t wait) : due_(wait + std::size_t{1}, 0), wait_(wait) {}

    void push(std::uint32_t request, std::uint32_t asker);

    [[nodiscard]] bool empty() const { return first_ == kNone; }

    /// The request whose turn it is; the queue is not empty.
    [[nodiscard]] std::uint32_t front() const { return askers_[first_].first; }

    /// Takes it out. Its asker's next one takes a turn at the end.
    void pop();

    /// A tick has begun.
    void tick() { ++now_; }

    /// So many of the first must be served in this tick that none waits too long if each tick from
    /// now on serves as many: the most, over times t ahead, of those due by then shared out evenly.
    [[nodiscard]] std::uint32_t required() const;

    /// Who waits, in order.
    [[nodiscard]] std::vector<SavedTurn> turns() const;

    /// In a queue that nobody was in: those wait, in that order.
    void load(const std::vector<SavedTurn>& turns);

    /// Ticks that the front has waited.
    [[nodiscard]] std::uint32_t waited() const { return now_ - requests_[front()].turn; }

  private:
    struct Turn {
        std::uint32_t next = kNone;  ///< of the same asker
        std::uint32_t turn = 0;      ///< tick in which it became its asker's first
    };

    struct Asker {
        std::uint32_t first = kNone;
        std::uint32_t last = kNone;
        std::uint32_t next = kNone;  ///< whose turn is next
    };

    void take_turn(std::uint32_t asker);
    /// Puts it behind the last one; its turn began in that tick.
    void line_up(std::uint32_t asker, std::uint32_t turn);

    std::vector<Turn> requests_;
    std::vector<Asker> askers_;
    std::uint32_t first_ = kNone;  // askers
    std::uint32_t last_ = kNone;
    std::uint32_t now_ = 0;
    std::vector<std::uint32_t> due_;  // turns by the tick in which they are due, modulo its size
    std::uint32_t wait_;
};

}  // namespace zoned::ai::pathfinding
