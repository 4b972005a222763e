#include "server/ai/minds.h"

#include "server/ai/decision.h"
#include "shared/core/assert.h"

#include <algorithm>
#include <cmath>

namespace zoned::ai {

namespace {

/// A change back that comes later than this is no wavering, s.
constexpr float kToAndFroS = 2.0F;

}  // namespace

std::size_t Minds::place_of(EntityId entity) const {
    const auto at =
        std::lower_bound(order_.begin(), order_.end(), entity, [](const Place& p, EntityId wanted) {
            return p.entity < wanted;
        });
    return static_cast<std::size_t>(at - order_.begin());
}

void Minds::add(const Mind& mind) {
    const std::size_t place = place_of(mind.entity);
    ZONED_ASSERT(mind.entity && (place == order_.size() || order_[place].entity != mind.entity),
                 "an entity has one mind");
    Slot slot = static_cast<Slot>(minds_.size());
    if (free_.empty()) {
        minds_.push_back(mind);
        traces_.emplace_back();
    } else {
        slot = free_.back();
        free_.pop_back();
        minds_[slot] = mind;
        traces_[slot] = fsm::Oscillations::Trace();
    }
    order_.insert(order_.begin() + static_cast<std::ptrdiff_t>(place), {mind.entity, slot});
    events_.grow(minds_.size());
    leaving_.grow(minds_.size());
    cells_.grow(minds_.size());
    waits_.grow(minds_.size());
    if (mind.tier == Tier::kAwake) {
        insert_awake(slot);
        return;
    }
    events_.schedule(slot, mind.next_event);
    leaving_.schedule(slot, 0);
    if (mind.wait.any()) {
        newly_waiting_.push_back(slot);
    }
}

Mind Minds::take(EntityId entity) {
    const std::size_t place = place_of(entity);
    ZONED_ASSERT(place < order_.size() && order_[place].entity == entity, "a mind to take exists");
    const Slot slot = order_[place].slot;
    if (minds_[slot].tier == Tier::kAwake) {
        erase_awake(slot);
    } else {
        forget_coarse(slot);
    }
    order_.erase(order_.begin() + static_cast<std::ptrdiff_t>(place));
    const Mind mind = minds_[slot];
    minds_[slot].entity = EntityId();
    free_.push_back(slot);
    return mind;
}

const Mind* Minds::find(EntityId entity) const {
    const std::size_t place = place_of(entity);
    return place < order_.size() && order_[place].entity == entity ? &minds_[order_[place].slot]
                                                                   : nullptr;
}

Mind* Minds::find(EntityId entity) {
    return const_cast<Mind*>(static_cast<const Minds*>(this)->find(entity));
}

void Minds::insert_awake(Slot slot) {
    const auto at = std::lower_bound(awake_.begin(), awake_.end(), slot, [this](Slot a, Slot b) {
        return minds_[a].entity < minds_[b].entity;
    });
    awake_.insert(at, slot);
}

void Minds::erase_awake(Slot slot) {
    awake_.erase(std::lower_bound(awake_.begin(), awake_.end(), slot, [this](Slot a, Slot b) {
        return minds_[a].entity < minds_[b].entity;
    }));
}

void Minds::wake(Slot slot) {
    minds_[slot].tier = Tier::kAwake;
    minds_[slot].next_event = kNever;
    minds_[slot].wait = StockWait{};
    forget_coarse(slot);
    insert_awake(slot);
}

void Minds::wake(EntityId entity) {
    wake(order_[place_of(entity)].slot);
}

void Minds::put_to_sleep(Slot slot) {
    erase_awake(slot);
    minds_[slot].tier = Tier::kCoarse;
    leaving_.schedule(slot, 0);
}

void Minds::schedule(Slot slot, Tick period) {
    events_.schedule(slot, minds_[slot].next_event);
    wait(slot, period);
}

void Minds::wait(Slot slot, Tick period) {
    const Mind& mind = minds_[slot];
    if (mind.wait.any()) {
        waits_.join(
            slot, mind.entity, {mind.machine, mind.fsm.state(), mind.doing, mind.wait, period});
    } else {
        waits_.leave(slot);
    }
}

void Minds::call_up(Slot slot, Tick now) {
    Mind& mind = minds_[slot];
    mind.next_decision = now;
    mind.next_event = kNever;
    mind.wait = StockWait{};
    events_.cancel(slot);
    waits_.leave(slot);
}

void Minds::take_due(Tick now, std::vector<Event>& due) {
    const std::size_t before = due.size();
    events_.take_due(now, [&](Slot slot, Tick at) {
        prefetch(slot);
        due.push_back({at, EntityId(), slot});
    });
    for (std::size_t i = before; i < due.size(); ++i) {
        Mind& mind = minds_[due[i].slot];
        mind.next_event = kNever;
        due[i].entity = mind.entity;
        if (const StockWaits::Group* const group = waits_.group_of(due[i].slot)) {
            const Tick period = group->key().period;
            mind.next_decision =
                std::min(mind.next_decision, next_decision(mind.entity, period, now - 1));
            mind.wait = StockWait{};
            due[i].waited = true;
            waits_.leave(due[i].slot);
        }
    }
}

/// They are anywhere in memory, and all of one is used.
void Minds::prefetch(Slot slot) const {
    constexpr std::size_t kLine = 64;
    const char* const mind = reinterpret_cast<const char*>(&minds_[slot]);
    for (std::size_t at = 0; at < sizeof(Mind); at += kLine) {
        __builtin_prefetch(mind + at, 1);
    }
    __builtin_prefetch(mind + sizeof(Mind) - 1, 1);
    __builtin_prefetch(&traces_[slot], 1);
    events_.prefetch(slot);
    leaving_.prefetch(slot);
    cells_.prefetch(slot);
    waits_.prefetch(slot);
}

void Minds::take_left(Tick now, std::vector<Slot>& left) {
    leaving_.take_due(now, [&](Slot slot, Tick /*at*/) {
        prefetch(slot);
        left.push_back(slot);
    });
}

void Minds::forget_coarse(Slot slot) {
    events_.cancel(slot);
    leaving_.cancel(slot);
    cells_.take(slot);
    waits_.leave(slot);
}

void Minds::watch(Slot slot, fsm::Change change, Tick now, float dt) {
    const Mind& mind = minds_[slot];
    if (wavering_.size() <= mind.machine) {
        fsm::OscillationSettings settings;
        settings.window = std::max<Tick>(1, std::lround(kToAndFroS / dt));
        wavering_.resize(mind.machine + 1U, fsm::Oscillations(settings));
    }
    change.mind = mind.entity.value;
    wavering_[mind.machine].watch(traces_[slot], change, now);
}

std::span<const fsm::Oscillation> Minds::wavering(std::size_t machine) const {
    return machine < wavering_.size() ? wavering_[machine].found()
                                      : std::span<const fsm::Oscillation>();
}

void Minds::forget_wavering() {
    wavering_.clear();
    std::fill(traces_.begin(), traces_.end(), fsm::Oscillations::Trace());
}

void Minds::hash(core::StateHash& hash) const {
    hash.add(static_cast<std::uint64_t>(order_.size()));
    for (const Place& place : order_) {
        ai::hash(hash, minds_[place.slot]);
    }
}

}  // namespace zoned::ai
