#include "server/ai/update/trade_update.h"

#include "server/ai/offscreen/next_change_forecast.h"
#include "server/ai/offscreen/suspend_resume.h"

#include <algorithm>

namespace zoned::ai {

namespace {

/// Keeps the smallest entity on top of the heap.
bool comes_later(const StockWaitList::WaitMember& a, const StockWaitList::WaitMember& b) {
    return b.entity < a.entity;
}

/// Whether some trade that the group waits for can be done.
bool some_trade_can(const StockWaitList::WaitKey& key, const AiContext& ai) {
    const std::vector<Trade>& trades =
        ai.settings.compiled[key.brain].states[key.current_action].trades;
    for (std::size_t t = 0; t < trades.size(); ++t) {
        if ((key.wait.trades & 1U << t) != 0 && ai.points_of_interest.can(trades[t], ai.now)) {
            return true;
        }
    }
    return false;
}

}  // namespace

/// Calls up the agents that wait for stock, decide in this tick and will find that the stock has
/// changed.
void TradeUpdate::call_up_waiting(const AiContext& ai, AiTurn& turn) {
    const StockWaitList& waits = ai.agents.waits(
        [&](const Agent& agent) { return decision_period(brain_of(agent, ai.settings), ai.dt); });
    const std::size_t before = turn.events.size();
    for (const StockWaitList::WaitGroup& group : waits.groups()) {
        const StockWaitList::WaitKey& key = group.key();
        if (key.wait.clauses == 0 || group.near(ai.now).empty() ||
            !stock_changed(key.wait,
                           ai.settings.compiled[key.brain],
                           key.leaf,
                           ai.points_of_interest,
                           ai.now)) {
            continue;
        }
        for (const StockWaitList::WaitMember& member : group.near(ai.now)) {
            if (group.decides_at(member.entity, ai.now)) {
                turn.events.push_back({ai.now, member.entity, member.slot});
            }
        }
    }
    for (std::size_t i = before; i < turn.events.size(); ++i) {
        ai.agents.call_up(turn.events[i].slot, ai.now);
    }
}

/// Collects the agents that have something to do in this tick and want to trade.
void TradeUpdate::collect_traders(const AiContext& ai, AiTurn& turn) {
    traders_.clear();
    for (std::uint32_t i = 0; i < turn.due.size(); ++i) {
        Agent& agent = ai.agents.at(turn.due[i].slot);
        if (turn.due[i].changed) {
            agent.wants = all_trades(brain_of(agent, ai.settings).states[agent.current_action]);
        }
        if (turn.due[i].decides && agent.wants != 0) {
            traders_.push_back(i);
        }
    }
    std::sort(traders_.begin(), traders_.end(), [&turn](std::uint32_t a, std::uint32_t b) {
        return turn.due[a].entity < turn.due[b].entity;
    });
}

/// Collects the waiting agents that decide in this tick and will trade if stock allows it at their
/// turn.
void TradeUpdate::collect_waiting_traders(const AiContext& ai) {
    waiting_trader_groups_ = 0;
    const StockWaitList& waits = ai.agents.waits(
        [&](const Agent& agent) { return decision_period(brain_of(agent, ai.settings), ai.dt); });
    for (const StockWaitList::WaitGroup& group : waits.groups()) {
        if (group.key().wait.trades == 0 || group.near(ai.now).empty()) {
            continue;
        }
        if (waiting_trader_groups_ == waiting_traders_.size()) {
            waiting_traders_.emplace_back();
        }
        WaitingTraders& waiting = waiting_traders_[waiting_trader_groups_++];
        waiting.group = &group;
        waiting.queued = false;
    }
}

/// Checks the stock for waiting agents whose turn comes after that of `after`.
void TradeUpdate::look_at_stock(const AiContext& ai, EntityId after) {
    for (std::size_t w = 0; w < waiting_trader_groups_; ++w) {
        WaitingTraders& waiting = waiting_traders_[w];
        waiting.may = some_trade_can(waiting.group->key(), ai);
        if (!waiting.may) {
            continue;
        }
        if (!waiting.queued) {
            waiting.queued = true;
            waiting.next.clear();
            for (const StockWaitList::WaitMember& member : waiting.group->near(ai.now)) {
                if (waiting.group->decides_at(member.entity, ai.now)) {
                    waiting.next.push_back(member);
                }
            }
            std::make_heap(waiting.next.begin(), waiting.next.end(), comes_later);
        }
        while (!waiting.next.empty() && !(after < waiting.next.front().entity)) {
            std::pop_heap(waiting.next.begin(), waiting.next.end(), comes_later);
            waiting.next.pop_back();
        }
    }
}

/// Null: no agent.
TradeUpdate::WaitingTraders* TradeUpdate::first_waiting_trader() {
    WaitingTraders* first = nullptr;
    for (std::size_t w = 0; w < waiting_trader_groups_; ++w) {
        WaitingTraders& waiting = waiting_traders_[w];
        if (waiting.may && !waiting.next.empty() &&
            (first == nullptr || waiting.next.front().entity < first->next.front().entity)) {
            first = &waiting;
        }
    }
    return first;
}

/// A waiting agent has something to do in this tick after all, and becomes the last of turn.due.
/// False: it does not decide in this tick.
bool TradeUpdate::call_up_trader(const AiContext& ai,
                                 AiTurn& turn,
                                 MeetingUpdate& meetings,
                                 Slot slot) {
    Agent& agent = ai.agents.at(slot);
    const world::Row row = row_of(ai.entities, agent.entity, turn.row_hints[slot]);
    turn.row_hints[slot] = row;
    if (row == world::kNoRow) {
        return false;
    }
    ai.agents.call_up(slot, ai.now);
    if (turn.due.size() >= std::max<std::size_t>(1, ai.settings.max_decisions_per_tick)) {
        agent.next_event = ai.now;
        ai.agents.schedule(slot, 1);
        meetings.settle(ai, turn, slot, std::max(left_at(agent, ai, true), ai.now + 1), true);
        ++turn.report.postponed;
        return false;
    }
    catch_up(agent, ai, row);
    DueAgent due{ai.now, agent.entity, slot, row, Tier::kSuspended};
    due.moved = ai.entities.discontinuity_tick[row] == ai.now;
    turn.due.push_back(due);
    return true;
}

void TradeUpdate::trade(const AiContext& ai, AiTurn& turn, std::uint32_t number) {
    DueAgent& due = turn.due[number];
    Agent& agent = ai.agents.at(due.slot);
    const Vec3& position = ai.entities.position[due.row];
    const Vec2 body(position.x(), position.z());
    const TradeResult result = ai::settle_trades(agent,
                                                 brain_of(agent, ai.settings),
                                                 whereabouts(agent, body, ai.now, ai.dt),
                                                 ai.points_of_interest,
                                                 ai.now);
    turn.report.trades += result.done;
    turn.report.trades_refused += result.refused;
    due.changed = due.changed || result.done > 0;
    if (result.done > 0) {
        look_at_stock(ai, due.entity);
    }
}

/// An action may ask for trades. If two agents want the last loaf, the one with the smaller id gets
/// it, whichever decided first. The other agent goes on asking as long as its action asks.
/// Suspended agents that wait for stock ask at each of their decisions too. They are called up
/// where stock allows the trade at their turn.
void TradeUpdate::settle_trades(const AiContext& ai, AiTurn& turn, MeetingUpdate& meetings) {
    collect_traders(ai, turn);
    collect_waiting_traders(ai);
    look_at_stock(ai, EntityId());
    for (std::size_t next = 0;;) {
        WaitingTraders* const waiting = first_waiting_trader();
        const bool due = next < traders_.size();
        if (due && (waiting == nullptr ||
                    turn.due[traders_[next]].entity < waiting->next.front().entity)) {
            trade(ai, turn, traders_[next++]);
            continue;
        }
        if (waiting == nullptr) {
            return;
        }
        const Slot slot = waiting->next.front().slot;
        std::pop_heap(waiting->next.begin(), waiting->next.end(), comes_later);
        waiting->next.pop_back();
        if (call_up_trader(ai, turn, meetings, slot)) {
            trade(ai, turn, static_cast<std::uint32_t>(turn.due.size() - 1));
        }
    }
}

}  // namespace zoned::ai
