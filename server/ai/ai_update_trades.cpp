#include "server/ai/ai_update.h"
#include "server/ai/ai_update_lookup.h"
#include "server/ai/offscreen/next_change_forecast.h"

#include <algorithm>

namespace zoned::ai {

namespace {

/// The smallest entity is on top of the heap.
bool comes_later(const StockWaitList::WaitMember& a, const StockWaitList::WaitMember& b) {
    return b.entity < a.entity;
}

/// Whether some trade that the group waits for can be done.
bool some_trade_can(const StockWaitList::WaitKey& key,
                    const AiSettings& settings,
                    const PointsOfInterest& points_of_interest,
                    Tick now) {
    const std::vector<Trade>& trades =
        settings.compiled[key.brain].states[key.current_action].trades;
    for (std::size_t t = 0; t < trades.size(); ++t) {
        if ((key.wait.trades & 1U << t) != 0 && points_of_interest.can(trades[t], now)) {
            return true;
        }
    }
    return false;
}

}  // namespace

/// Of those who wait for stock, whoever decides in this tick and will find it other than it was.
void AiUpdate::call_up_waiting(AgentStore& agents,
                               const AiContext& world,
                               const AiSettings& settings) {
    const StockWaitList& waits = agents.waits(
        [&](const Agent& agent) { return decision_period(brain_of(agent, settings), world.dt); });
    const std::size_t before = events_.size();
    for (const StockWaitList::WaitGroup& group : waits.groups()) {
        const StockWaitList::WaitKey& key = group.key();
        if (key.wait.clauses == 0 || group.near(world.now).empty() ||
            !stock_changed(key.wait,
                           settings.compiled[key.brain],
                           key.leaf,
                           world.points_of_interest,
                           world.now)) {
            continue;
        }
        for (const StockWaitList::WaitMember& member : group.near(world.now)) {
            if (group.decides_at(member.entity, world.now)) {
                events_.push_back({world.now, member.entity, member.slot});
            }
        }
    }
    for (std::size_t i = before; i < events_.size(); ++i) {
        agents.call_up(events_[i].slot, world.now);
    }
}

/// Those who have something to do in this tick, and want to trade.
void AiUpdate::collect_traders(AgentStore& agents, const AiSettings& settings) {
    traders_.clear();
    for (std::uint32_t i = 0; i < due_.size(); ++i) {
        Agent& agent = agents.at(due_[i].slot);
        if (due_[i].changed) {
            agent.wants = all_trades(brain_of(agent, settings).states[agent.current_action]);
        }
        if (due_[i].decides && agent.wants != 0) {
            traders_.push_back(i);
        }
    }
    std::sort(traders_.begin(), traders_.end(), [this](std::uint32_t a, std::uint32_t b) {
        return due_[a].entity < due_[b].entity;
    });
}

/// Those who decide in this tick, and will trade if the stock is so when it is their turn.
void AiUpdate::collect_waiting_traders(AgentStore& agents,
                                       const AiContext& world,
                                       const AiSettings& settings) {
    waiting_trader_groups_ = 0;
    const StockWaitList& waits = agents.waits(
        [&](const Agent& agent) { return decision_period(brain_of(agent, settings), world.dt); });
    for (const StockWaitList::WaitGroup& group : waits.groups()) {
        if (group.key().wait.trades == 0 || group.near(world.now).empty()) {
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

/// Who waits and may trade now: of those whose turn comes after that of `after`.
void AiUpdate::look_at_stock(const AiContext& world, const AiSettings& settings, EntityId after) {
    for (std::size_t w = 0; w < waiting_trader_groups_; ++w) {
        WaitingTraders& waiting = waiting_traders_[w];
        waiting.may =
            some_trade_can(waiting.group->key(), settings, world.points_of_interest, world.now);
        if (!waiting.may) {
            continue;
        }
        if (!waiting.queued) {
            waiting.queued = true;
            waiting.next.clear();
            for (const StockWaitList::WaitMember& member : waiting.group->near(world.now)) {
                if (waiting.group->decides_at(member.entity, world.now)) {
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

/// Null: nobody.
AiUpdate::WaitingTraders* AiUpdate::first_waiting_trader() {
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

/// Somebody who waited has something to do in this tick after all: the last of due_ from now on.
/// False: not in this one.
bool AiUpdate::call_up_trader(AgentStore& agents,
                              const AiContext& world,
                              const AiSettings& settings,
                              Slot slot) {
    Agent& agent = agents.at(slot);
    const world::Row row = row_of(world.entities, agent.entity, row_hints_[slot]);
    row_hints_[slot] = row;
    if (row == world::kNoRow) {
        return false;
    }
    agents.call_up(slot, world.now);
    if (due_.size() >= std::max<std::size_t>(1, settings.max_decisions_per_tick)) {
        agent.next_event = world.now;
        agents.schedule(slot, 1);
        settle(agents, slot, std::max(left_at(agent, world, true), world.now + 1), world, true);
        ++report_.postponed;
        return false;
    }
    catch_up(agent, offscreen(world), row);
    DueAgent due{world.now, agent.entity, slot, row, Tier::kSuspended};
    due.moved = world.entities.discontinuity_tick[row] == world.now;
    due_.push_back(due);
    return true;
}

void AiUpdate::trade(AgentStore& agents,
                     const AiContext& world,
                     const AiSettings& settings,
                     std::uint32_t number) {
    DueAgent& due = due_[number];
    Agent& agent = agents.at(due.slot);
    const Vec3& position = world.entities.position[due.row];
    const Vec2 body(position.x(), position.z());
    const TradeResult bargain = ai::settle_trades(agent,
                                                  brain_of(agent, settings),
                                                  whereabouts(agent, body, world.now, world.dt),
                                                  world.points_of_interest,
                                                  world.now);
    report_.trades += bargain.done;
    report_.trades_refused += bargain.refused;
    due.changed = due.changed || bargain.done > 0;
    if (bargain.done > 0) {
        look_at_stock(world, settings, due.entity);
    }
}

/// What agents do may ask for trades. Two that want the last loaf: the smaller id gets it, whoever
/// decided first; the other one goes on asking as long as it does what asks. Offscreen agents that
/// wait for stock ask as well at each of their decisions: they come up where the stock is so when
/// it is their turn.
void AiUpdate::settle_trades(AgentStore& agents,
                             const AiContext& world,
                             const AiSettings& settings) {
    collect_traders(agents, settings);
    collect_waiting_traders(agents, world, settings);
    look_at_stock(world, settings, EntityId());
    for (std::size_t next = 0;;) {
        WaitingTraders* const waiting = first_waiting_trader();
        const bool due = next < traders_.size();
        if (due &&
            (waiting == nullptr || due_[traders_[next]].entity < waiting->next.front().entity)) {
            trade(agents, world, settings, traders_[next++]);
            continue;
        }
        if (waiting == nullptr) {
            return;
        }
        const Slot slot = waiting->next.front().slot;
        std::pop_heap(waiting->next.begin(), waiting->next.end(), comes_later);
        waiting->next.pop_back();
        if (call_up_trader(agents, world, settings, slot)) {
            trade(agents, world, settings, static_cast<std::uint32_t>(due_.size() - 1));
        }
    }
}

}  // namespace zoned::ai
