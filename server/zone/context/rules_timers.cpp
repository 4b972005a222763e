#include "server/zone/context/rules_timers.h"

#include <algorithm>
#include <tuple>

namespace zoned::zone {

namespace {

bool later(const RulesTimer& a, const RulesTimer& b) {
    return std::tie(a.due, a.call.id) > std::tie(b.due, b.call.id);
}

}  // namespace

void RulesTimers::note(const RulesTimer& timer) {
    core::StateHash mix;
    mix.add(changes_);
    mix.add(timer.due);
    mix.add(timer.call.id.value);
    mix.add(timer.call.entity.value);
    mix.add(timer.call.kind);
    mix.add_bytes(timer.call.payload);
    changes_ = mix.value();
    changed_ = true;
}

void RulesTimers::add(RulesTimer timer) {
    note(timer);
    heap_.push_back(std::move(timer));
    std::push_heap(heap_.begin(), heap_.end(), later);
}

TimerId RulesTimers::start(ZoneId zone,
                           Tick due,
                           EntityId entity,
                           std::uint16_t kind,
                           Bytes payload) {
    if (heap_.size() >= kMostTimers) {
        return {};
    }
    const TimerId id((++started_ << 16U) | zone.value);
    add({due, {id, entity, kind, std::move(payload)}});
    return id;
}

template <class Which>
std::vector<RulesTimer> RulesTimers::remove(Which&& which) {
    const auto kept = std::partition(
        heap_.begin(), heap_.end(), [&](const RulesTimer& timer) { return !which(timer); });
    std::vector<RulesTimer> removed(std::make_move_iterator(kept),
                                    std::make_move_iterator(heap_.end()));
    if (!removed.empty()) {
        heap_.erase(kept, heap_.end());
        std::make_heap(heap_.begin(), heap_.end(), later);
        // In an order of its own: that of a heap depends on what was there before.
        std::sort(removed.begin(), removed.end(), [](const RulesTimer& a, const RulesTimer& b) {
            return later(b, a);
        });
        for (const RulesTimer& timer : removed) {
            note(timer);
        }
    }
    return removed;
}

void RulesTimers::stop(TimerId timer) {
    remove([&](const RulesTimer& t) { return t.call.id == timer; });
}

void RulesTimers::clear() {
    remove([](const RulesTimer& /*timer*/) { return true; });
}

std::optional<DueTimer> RulesTimers::next(Tick now) {
    if (!due(now)) {
        return std::nullopt;
    }
    std::pop_heap(heap_.begin(), heap_.end(), later);
    note(heap_.back());
    DueTimer call = std::move(heap_.back().call);
    heap_.pop_back();
    return call;
}

std::vector<RulesTimer> RulesTimers::take(EntityId entity) {
    if (heap_.empty()) {
        return {};
    }
    return remove([&](const RulesTimer& t) { return t.call.entity == entity; });
}

void RulesTimers::give(std::vector<RulesTimer> timers) {
    for (RulesTimer& timer : timers) {
        add(std::move(timer));
    }
}

void RulesTimers::hash_changes(core::StateHash& hash) {
    if (changed_) {
        hash.add(changes_);
        changes_ = 0;
        changed_ = false;
    }
}

}  // namespace zoned::zone
