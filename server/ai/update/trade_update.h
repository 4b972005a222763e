// TradeUpdate: trades at points of interest, and the agents that wait for stock.
#pragma once

#include "server/ai/update/meeting_update.h"

#include <cstdint>
#include <vector>

namespace zoned::ai {

class TradeUpdate {
  public:
    /// Adds those to turn.events who wait for stock, decide in this tick and will find it other
    /// than it was.
    void call_up_waiting(const AiContext& ai, AiTurn& turn);

    /// Does what the agents of turn.due, and those who wait for stock, want to trade, ascending by
    /// entity. Who has waited and trades becomes one of turn.due.
    void settle_trades(const AiContext& ai, AiTurn& turn, MeetingUpdate& meetings);

  private:
    /// Suspended agents that decide in this tick, and would trade if only the stock were so.
    struct WaitingTraders {
        const StockWaitList::WaitGroup* group = nullptr;
        bool may = false;     ///< the stock is so
        bool queued = false;  ///< `next` is what it should be
        /// Whose turn is still to come, a heap by entity.
        std::vector<StockWaitList::WaitMember> next;
    };

    void collect_traders(const AiContext& ai, AiTurn& turn);
    void collect_waiting_traders(const AiContext& ai);
    void look_at_stock(const AiContext& ai, EntityId after);
    [[nodiscard]] WaitingTraders* first_waiting_trader();
    bool call_up_trader(const AiContext& ai, AiTurn& turn, MeetingUpdate& meetings, Slot slot);
    void trade(const AiContext& ai, AiTurn& turn, std::uint32_t number);

    std::vector<std::uint32_t> traders_;           // of turn.due, ascending by entity
    std::vector<WaitingTraders> waiting_traders_;  // the first some of them count
    std::size_t waiting_trader_groups_ = 0;
};

}  // namespace zoned::ai
