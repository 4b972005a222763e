#include "server/ai/minds.h"

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
    if (mind.tier == Tier::kAwake) {
        insert_awake(slot);
    } else {
        schedule(slot);
    }
}

Mind Minds::take(EntityId entity) {
    const std::size_t place = place_of(entity);
    ZONED_ASSERT(place < order_.size() && order_[place].entity == entity, "a mind to take exists");
    const Slot slot = order_[place].slot;
    if (minds_[slot].tier == Tier::kAwake) {
        erase_awake(slot);
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
    insert_awake(slot);
}

void Minds::wake(EntityId entity) {
    wake(order_[place_of(entity)].slot);
}

void Minds::put_to_sleep(Slot slot) {
    minds_[slot].tier = Tier::kCoarse;
    erase_awake(slot);
}

bool Minds::later(const Event& a, const Event& b) {
    return a.at != b.at ? a.at > b.at : b.entity < a.entity;
}

void Minds::schedule(Slot slot) {
    const Mind& mind = minds_[slot];
    if (mind.next_event != kNever) {
        events_.push_back({mind.next_event, mind.entity, slot});
        std::push_heap(events_.begin(), events_.end(), later);
    }
}

void Minds::take_due(Tick now, std::vector<Event>& due) {
    while (!events_.empty() && events_.front().at <= now) {
        const Event event = events_.front();
        std::pop_heap(events_.begin(), events_.end(), later);
        events_.pop_back();
        Mind& mind = minds_[event.slot];
        if (mind.entity == event.entity && mind.tier == Tier::kCoarse &&
            mind.next_event == event.at) {
            mind.next_event = kNever;  // so that a second event of the same time is void
            due.push_back(event);
        }
    }
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
