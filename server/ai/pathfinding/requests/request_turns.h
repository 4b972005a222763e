// RequestTurns: the queue of waiting path requests, their turns, and the number to serve in a tick.
#pragma once

#include "server/ai/pathfinding/requests/saved_paths.h"

#include <cstdint>
#include <vector>

namespace zoned::ai::pathfinding {

/// First come, first served among askers. An asker with several requests waits for each in turn, so
/// its many requests delay nobody else. Requests are small numbers; so are askers. Allocates only
/// where one is larger than any before.
class RequestTurns {
  public:
    static constexpr std::uint32_t kNone = ~0U;

    /// `wait` is the longest time until an asker's turn comes, in ticks.
    explicit RequestTurns(std::uint32_t wait) : due_(wait + std::size_t{1}, 0), wait_(wait) {}

    void push(std::uint32_t request, std::uint32_t asker);

    [[nodiscard]] bool empty() const { return first_ == kNone; }

    /// The request whose turn it is; the queue must not be empty.
    [[nodiscard]] std::uint32_t front() const { return askers_[first_].first; }

    /// Takes out the front. The next request of its asker takes a turn at the end.
    void pop();

    /// Begins a tick.
    void tick() { ++now_; }

    /// The number of requests to serve in this tick. If each tick from now on serves as many, none
    /// waits too long. It is the largest, over times t ahead, of the requests due by then divided
    /// evenly.
    [[nodiscard]] std::uint32_t required() const;

    /// The waiting askers, in order.
    [[nodiscard]] std::vector<SavedTurn> turns() const;

    /// Loads turns into an empty queue, in that order.
    void load(const std::vector<SavedTurn>& turns);

    /// The number of ticks that the front has waited.
    [[nodiscard]] std::uint32_t waited() const { return now_ - requests_[front()].turn; }

  private:
    struct Turn {
        std::uint32_t next = kNone;  ///< next request of the same asker
        std::uint32_t turn = 0;      ///< tick in which it became its asker's first
    };

    struct Asker {
        std::uint32_t first = kNone;
        std::uint32_t last = kNone;
        std::uint32_t next = kNone;  ///< asker whose turn is next
    };

    void take_turn(std::uint32_t asker);
    /// Puts an asker behind the last one; its turn began in that tick.
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
