// AgentStore: all agents of one zone, and which of them have something to do.
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

/// AgentPlace of an agent in memory; stays while the agent is here.
using Slot = std::uint32_t;

class AgentStore {
  public:
    /// An event that was planned.
    struct Event {
        Tick at;
        EntityId entity;
        Slot slot;
        bool waited = false;  ///< for stock
    };

    /// An entity has one agent; its `brain` must exist in the settings.
    void add(const Agent& agent);

    /// Removes and returns (for a handoff); the entity must have one.
    Agent take(EntityId entity);

    [[nodiscard]] const Agent* find(EntityId entity) const;
    [[nodiscard]] Agent* find(EntityId entity);

    /// Of an entity that has one.
    [[nodiscard]] Slot slot_of(EntityId entity) const { return order_[place_of(entity)].slot; }

    [[nodiscard]] std::size_t size() const { return order_.size(); }

    [[nodiscard]] Agent& at(Slot slot) { return agents_[slot]; }

    [[nodiscard]] const Agent& at(Slot slot) const { return agents_[slot]; }

    /// Slots of the agents of the active tier, ascending by entity id.
    [[nodiscard]] std::span<const Slot> active() const { return active_; }

    /// Slots are smaller than this.
    [[nodiscard]] std::size_t slots() const { return agents_.size(); }

    /// The n-th agent by entity id, n < size().
    [[nodiscard]] Slot nth(std::size_t n) const { return order_[n].slot; }

    /// Changes the tier.
    void resume(Slot slot);
    void resume(EntityId entity);
    void suspend(Slot slot);

    /// Of a suspended agent: it is among the due ones at `agent.next_event`, as that is now, and
    /// waits for `agent.wait`. `period` is that of its decisions, ticks.
    void schedule(Slot slot, Tick period);

    /// Appends what is due at `now`, in no order, and forgets that it is, and what it waited for;
    /// who did wait decides as well when its decision is due. Ticks ascend.
    void take_due(Tick now, std::vector<Event>& due);

    /// Asks for all that is linked with a suspended agent; take_due() and take_left() have asked
    /// for the agent itself.
    void prefetch_neighbours(Slot slot) const {
        leaving_.prefetch_neighbours(slot);
        cells_.prefetch_neighbours(slot);
    }

    /// The agents that wait for stock; `period_of` tells the period of an agent's decisions, ticks,
    /// for those that came with what they wait for.
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

    /// A suspended agent that waits for stock decides at `now`: it waits no more, and nothing else
    /// is planned for it.
    void call_up(Slot slot, Tick now);

    /// Of a suspended agent whose segment is another one than before, or was left: the squares that
    /// it comes through, and when it leaves them, OffscreenGrid::left_at(). `dt` in s. `late`: it
    /// should have had an event before.
    void settle(Slot slot, Tick left, float dt, bool late = false) {
        cells_.put(slot, agents_[slot].segment, agents_[slot].placed, dt, late);
        if (leaving_.at(slot) != left) {
            leaving_.schedule(slot, left);
        }
    }

    /// When it leaves them, as settle() was told.
    [[nodiscard]] Tick left(Slot slot) const { return leaving_.at(slot); }

    /// Appends the suspended agents that leave their squares by `now` or were never settled, in no
    /// order; they have to be settled again. Ticks ascend.
    void take_left(Tick now, std::vector<Slot>& left);

    /// Calls visit(slot) for the suspended agents that were settled to come through a square, in no
    /// order.
    template <class Visit>
    void visit(OffscreenGrid::Cell cell, Visit&& visit) const {
        cells_.visit(cell, visit);
    }

    /// The same for those that may be anywhere.
    template <class Visit>
    void visit_anywhere(Visit&& visit) const {
        cells_.visit_anywhere(visit);
    }

    /// The agent changed its state: remembered for state_flapping(). `dt` in s.
    void watch(Slot slot, state_machine::StateChange change, Tick now, float dt);

    /// Pairs of states between which agents of that brain have gone to and fro, six times within
    /// 2 s each; `agent` is an entity's id. For reports: no state of the zone.
    [[nodiscard]] std::span<const state_machine::FlappingPair> state_flapping(
        std::size_t brain) const;

    /// Forgets what watch() saw: brains have become others.
    void forget_flapping();

    /// All agents, ascending by entity id.
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
    std::vector<Slot> newly_waiting_;  // who was added with something to wait for
};

}  // namespace zoned::ai
