// AgentStore: all agents of one zone, and the ticks of their next events.
#pragma once

#include "server/ai/agent/agent.h"
#include "server/ai/agent/agent_event_queue.h"
#include "server/ai/agent/offscreen_grid.h"
#include "server/ai/agent/stock_wait_list.h"
#include "server/ai/decision/state_machine/state_flapping.h"

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace zoned::ai {

/// Place of an agent in memory. It stays the same while the agent is in this zone.
using Slot = std::uint32_t;

class AgentStore {
  public:
    /// A scheduled event.
    struct Event {
        Tick at;
        EntityId entity;
        Slot slot;
        bool waited = false;  ///< it waited for stock
    };

    /// An entity has one agent. Its `brain` must exist in the settings.
    void add(const Agent& agent);

    /// Removes and returns an agent (for a handoff). The entity must have one.
    Agent take(EntityId entity);

    [[nodiscard]] const Agent* find(EntityId entity) const;
    [[nodiscard]] Agent* find(EntityId entity);

    /// The entity must have an agent.
    [[nodiscard]] Slot slot_of(EntityId entity) const { return order_[place_of(entity)].slot; }

    [[nodiscard]] std::size_t size() const { return order_.size(); }

    [[nodiscard]] Agent& at(Slot slot) { return agents_[slot]; }

    [[nodiscard]] const Agent& at(Slot slot) const { return agents_[slot]; }

    /// Slots of the active agents, ascending by entity id.
    [[nodiscard]] std::span<const Slot> active() const { return active_; }

    /// All slots are smaller than this.
    [[nodiscard]] std::size_t slots() const { return agents_.size(); }

    /// The n-th agent by entity id, n < size().
    [[nodiscard]] Slot nth(std::size_t n) const { return order_[n].slot; }

    /// Makes the agent active.
    void resume(Slot slot);
    void resume(EntityId entity);
    void suspend(Slot slot);

    /// Schedules a suspended agent's event at `agent.next_event`, and lets it wait for the stock in
    /// `agent.wait`. `period` is the period of its decisions, ticks.
    void schedule(Slot slot, Tick period);

    /// Appends the events due at `now`, in no order. Removes them and what their agents waited for.
    /// An agent that waited also decides when its decision is due. Ticks ascend.
    void take_due(Tick now, std::vector<Event>& due);

    /// Prefetches all that is linked to a suspended agent. take_due() and take_left() prefetch the
    /// agent itself.
    void prefetch_neighbours(Slot slot) const {
        leaving_.prefetch_neighbours(slot);
        cells_.prefetch_neighbours(slot);
    }

    /// The agents that wait for stock. `period_of` gives the decision period of an agent, ticks. It
    /// is needed for agents that were already waiting when they were added.
    template <class PeriodOf>
    const StockWaitList& waits(PeriodOf&& period_of) {
        for (const Slot slot : newly_waiting_) {
            if (agents_[slot].entity && agents_[slot].tier == Tier::kSuspended) {
                wait(slot, period_of(agents_[slot]));
            }
        }
        newly_waiting_.clear();
        return waits_;
    }

    /// Lets a suspended agent that waits for stock decide at `now`. It stops waiting, and has no
    /// other event scheduled.
    void call_up(Slot slot, Tick now);

    /// Updates the squares of a suspended agent whose segment has changed, or that has left its
    /// squares. `left`: when it leaves the new squares (OffscreenGrid::left_at()). `dt` in s.
    /// `late`: its event should have come before.
    void settle(Slot slot, Tick left, float dt, bool late = false) {
        cells_.put(slot, agents_[slot].segment, agents_[slot].placed, dt, late);
        if (leaving_.at(slot) != left) {
            leaving_.schedule(slot, left);
        }
    }

    /// The tick given to settle().
    [[nodiscard]] Tick left(Slot slot) const { return leaving_.at(slot); }

    /// Appends the suspended agents that leave their squares by `now`, or were never settled, in no
    /// order. Settle them again. Ticks ascend.
    void take_left(Tick now, std::vector<Slot>& left);

    /// Calls visit(slot) for each suspended agent whose walk leads through the square, in no order.
    template <class Visit>
    void visit(OffscreenGrid::Cell cell, Visit&& visit) const {
        cells_.visit(cell, visit);
    }

    /// Does the same for agents that may be anywhere.
    template <class Visit>
    void visit_anywhere(Visit&& visit) const {
        cells_.visit_anywhere(visit);
    }

    /// Records a change of state for state_flapping(). `dt` in s.
    void watch(Slot slot, state_machine::StateChange change, Tick now, float dt);

    /// Pairs of states between which agents of that brain have flapped: six changes, each within 2
    /// s. `agent` is an entity's id. For reports; not part of the zone's state.
    [[nodiscard]] std::span<const state_machine::FlappingPair> state_flapping(
        std::size_t brain) const;

    /// Forgets all recorded changes, since the brains have changed.
    void forget_flapping();

    /// Hashes all agents, ascending by entity id.
    void hash(core::StateHash& hash) const;

  private:
    struct AgentPlace {
        EntityId entity;
        Slot slot;
    };

    void wait(Slot slot, Tick period);
    void forget_suspended(Slot slot);
    void prefetch(Slot slot) const;
    [[nodiscard]] std::size_t place_of(EntityId entity) const;
    void insert_active(Slot slot);
    void erase_active(Slot slot);

    std::vector<Agent> agents_;                                    // by slot
    std::vector<state_machine::FlappingDetector::Trace> traces_;   // by slot
    std::vector<state_machine::FlappingDetector> state_flapping_;  // by brain
    std::vector<Slot> free_;
    std::vector<AgentPlace> order_;  // ascending by entity
    std::vector<Slot> active_;
    // Of suspended agents:
    AgentEventQueue events_;
    AgentEventQueue leaving_;
    OffscreenGrid cells_;
    StockWaitList waits_;
    std::vector<Slot> newly_waiting_;  // agents that were already waiting when they were added
};

}  // namespace zoned::ai
