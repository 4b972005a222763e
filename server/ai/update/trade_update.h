// TradeUpdate: trades at points of interest, and the agents that wait for stock.
#pragma once

#include "server/ai/update/meeting_update.h"

#include <cstdint>
#include <vector>

namespace zoned::ai {

class TradeUpdate {
  public:
    /// Adds to turn.events the agents that wait for stock, decide in this tick and will find that
    /// the stock has changed.
    void call_up_waiting(const AiContext& ai, AiTurn& turn);

    /// Does the trades of the agents in turn.due, and of those that wait for stock, ascending by
    /// entity. A waiting agent that trades joins turn.due.
    void settle_trades(const AiContext& ai, AiTurn& turn, MeetingUpdate& meetings);

  private:
    /// Suspended agents that decide in this tick, and would trade if stock allowed it.
    struct WaitingTraders {
        const StockWaitList::WaitGroup* group = nullptr;
        bool may = false;     ///< stock allows the trade
        bool queued = false;  ///< `next` is up to date
        /// The agents whose turn is still to come, a heap by entity.
        std::vector<StockWaitList::WaitMember> next;
    };

    void collect_traders(const AiContext& ai, AiTurn& turn);
    void collect_waiting_traders(const AiContext& ai);
    void look_at_stock(const AiContext& ai, EntityId after);
    [[nodiscard]] WaitingTraders* first_waiting_trader();
    bool call_up_trader(const AiContext& ai, AiTurn& turn, MeetingUpdate& meetings, Slot slot);
    void trade(const AiContext& ai, AiTurn& turn, std::uint32_t number);

    std::vector<std::uint32_t> traders_;           // indexes into turn.due, ascending by entity
    std::vector<WaitingTraders> waiting_traders_;  // first `waiting_trader_groups_` in use
    std::size_t waiting_trader_groups_ = 0;
};

}  // namespace zoned::ai
