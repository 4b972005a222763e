#include "server/ai/agent/agent_store.h"

#include "server/ai/agent/decision.h"
#include "shared/core/assert.h"

#include <algorithm>
#include <cmath>

namespace zoned::ai {

namespace {

/// A change back after more than this is no flapping, s.
constexpr float kToAndFroS = 2.0F;

}  // namespace

std::size_t AgentStore::place_of(EntityId entity) const {
    const auto at = std::lower_bound(
        order_.begin(), order_.end(), entity, [](const AgentPlace& p, EntityId wanted) {
            return p.entity < wanted;
        });
    return static_cast<std::size_t>(at - order_.begin());
}

void AgentStore::add(const Agent& agent) {
    const std::size_t place = place_of(agent.entity);
    ZONED_ASSERT(agent.entity && (place == order_.size() || order_[place].entity != agent.entity),
                 "an entity has one agent");
    Slot slot = static_cast<Slot>(agents_.size());
    if (free_.empty()) {
        agents_.push_back(agent);
        traces_.emplace_back();
    } else {
        slot = free_.back();
        free_.pop_back();
        agents_[slot] = agent;
        traces_[slot] = state_machine::FlappingDetector::Trace();
    }
    order_.insert(order_.begin() + static_cast<std::ptrdiff_t>(place), {agent.entity, slot});
    events_.grow(agents_.size());
    leaving_.grow(agents_.size());
    cells_.grow(agents_.size());
    waits_.grow(agents_.size());
    if (agent.tier == Tier::kActive) {
        insert_active(slot);
        return;
    }
    events_.schedule(slot, agent.next_event);
    leaving_.schedule(slot, 0);
    if (agent.wait.any()) {
        newly_waiting_.push_back(slot);
    }
}

Agent AgentStore::take(EntityId entity) {
    const std::size_t place = place_of(entity);
    ZONED_ASSERT(place < order_.size() && order_[place].entity == entity,
                 "an agent to take exists");
    const Slot slot = order_[place].slot;
    if (agents_[slot].tier == Tier::kActive) {
        erase_active(slot);
    } else {
        forget_suspended(slot);
    }
    order_.erase(order_.begin() + static_cast<std::ptrdiff_t>(place));
    const Agent agent = agents_[slot];
    agents_[slot].entity = EntityId();
    free_.push_back(slot);
    return agent;
}

const Agent* AgentStore::find(EntityId entity) const {
    const std::size_t place = place_of(entity);
    return place < order_.size() && order_[place].entity == entity ? &agents_[order_[place].slot]
                                                                   : nullptr;
}

Agent* AgentStore::find(EntityId entity) {
    return const_cast<Agent*>(static_cast<const AgentStore*>(this)->find(entity));
}

void AgentStore::insert_active(Slot slot) {
    const auto at = std::lower_bound(active_.begin(), active_.end(), slot, [this](Slot a, Slot b) {
        return agents_[a].entity < agents_[b].entity;
    });
    active_.insert(at, slot);
}

void AgentStore::erase_active(Slot slot) {
    active_.erase(std::lower_bound(active_.begin(), active_.end(), slot, [this](Slot a, Slot b) {
        return agents_[a].entity < agents_[b].entity;
    }));
}

void AgentStore::resume(Slot slot) {
    agents_[slot].tier = Tier::kActive;
    agents_[slot].next_event = kNever;
    agents_[slot].wait = StockWait{};
    forget_suspended(slot);
    insert_active(slot);
}

void AgentStore::resume(EntityId entity) {
    resume(order_[place_of(entity)].slot);
}

void AgentStore::suspend(Slot slot) {
    erase_active(slot);
    agents_[slot].tier = Tier::kSuspended;
    leaving_.schedule(slot, 0);
}

void AgentStore::schedule(Slot slot, Tick period) {
    events_.schedule(slot, agents_[slot].next_event);
    wait(slot, period);
}

void AgentStore::wait(Slot slot, Tick period) {
    const Agent& agent = agents_[slot];
    if (agent.wait.any()) {
        waits_.join(
            slot,
            agent.entity,
            {agent.brain, agent.state_machine.leaf, agent.current_action, agent.wait, period});
    } else {
        waits_.leave(slot);
    }
}

void AgentStore::call_up(Slot slot, Tick now) {
    Agent& agent = agents_[slot];
    agent.next_decision = now;
    agent.next_event = kNever;
    agent.wait = StockWait{};
    events_.cancel(slot);
    waits_.leave(slot);
}

void AgentStore::take_due(Tick now, std::vector<Event>& due) {
    const std::size_t before = due.size();
    events_.take_due(now, [&](Slot slot, Tick at) {
        prefetch(slot);
        due.push_back({at, EntityId(), slot});
    });
    for (std::size_t i = before; i < due.size(); ++i) {
        Agent& agent = agents_[due[i].slot];
        agent.next_event = kNever;
        due[i].entity = agent.entity;
        if (const StockWaitList::WaitGroup* const group = waits_.group_of(due[i].slot)) {
            const Tick period = group->key().period;
            agent.next_decision =
                std::min(agent.next_decision, next_decision(agent.entity, period, now - 1));
            agent.wait = StockWait{};
            due[i].waited = true;
            waits_.leave(due[i].slot);
        }
    }
}

/// Agents lie scattered in memory, and an agent is used whole.
void AgentStore::prefetch(Slot slot) const {
    constexpr std::size_t kLine = 64;
    const char* const agent = reinterpret_cast<const char*>(&agents_[slot]);
    for (std::size_t at = 0; at < sizeof(Agent); at += kLine) {
        __builtin_prefetch(agent + at, 1);
    }
    __builtin_prefetch(agent + sizeof(Agent) - 1, 1);
    __builtin_prefetch(&traces_[slot], 1);
    events_.prefetch(slot);
    leaving_.prefetch(slot);
    cells_.prefetch(slot);
    waits_.prefetch(slot);
}

void AgentStore::take_left(Tick now, std::vector<Slot>& left) {
    leaving_.take_due(now, [&](Slot slot, Tick /*at*/) {
        prefetch(slot);
        left.push_back(slot);
    });
}

void AgentStore::forget_suspended(Slot slot) {
    events_.cancel(slot);
    leaving_.cancel(slot);
    cells_.take(slot);
    waits_.leave(slot);
}

void AgentStore::watch(Slot slot, state_machine::StateChange change, Tick now, float dt) {
    const Agent& agent = agents_[slot];
    if (state_flapping_.size() <= agent.brain) {
        state_machine::FlappingSettings settings;
        settings.window = std::max<Tick>(1, std::lround(kToAndFroS / dt));
        state_flapping_.resize(agent.brain + 1U, state_machine::FlappingDetector(settings));
    }
    change.agent = agent.entity.value;
    state_flapping_[agent.brain].watch(traces_[slot], change, now);
}

std::span<const state_machine::FlappingPair> AgentStore::state_flapping(std::size_t brain) const {
    return brain < state_flapping_.size() ? state_flapping_[brain].found()
                                          : std::span<const state_machine::FlappingPair>();
}

void AgentStore::forget_flapping() {
    state_flapping_.clear();
    std::fill(traces_.begin(), traces_.end(), state_machine::FlappingDetector::Trace());
}

void AgentStore::hash(core::StateHash& hash) const {
    hash.add(static_cast<std::uint64_t>(order_.size()));
    for (const AgentPlace& place : order_) {
        ai::hash(hash, agents_[place.slot]);
    }
}

}  // namespace zoned::ai
