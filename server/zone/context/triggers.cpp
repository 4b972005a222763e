#include "server/zone/context/triggers.h"

#include "server/zone/zone_state.h"

#include <algorithm>
#include <iterator>

namespace zoned::zone {

namespace {

bool is_present(const world::Entities& e, world::Row row) {
    return row != world::kNoRow && !e.has(row, world::kGhost) && !e.has(row, world::kHidden);
}

/// Rows that may have come or gone: those that move, and those that something was done to.
void collect_moved(const world::Entities& e, std::vector<world::Row>& rows) {
    rows.clear();
    world::for_each_row(e.moving(), e.touched(world::Reader::kTriggers), [&](world::Row row) {
        if (is_present(e, row)) {
            rows.push_back(row);
        }
    });
}

/// Fills `now` with the entities in the box. One that rests and was not touched is where it was a
/// tick ago.
void look_into(const ZoneState& state,
               const Trigger& trigger,
               const std::vector<EntityId>& before,
               const std::vector<world::Row>& moved,
               std::vector<EntityId>& now) {
    const world::Entities& e = state.entities;
    now.clear();
    for (const EntityId entity : before) {
        const world::Row row = e.find(entity);
        if (is_present(e, row) && trigger.holds(e.position[row])) {
            now.push_back(entity);
        }
    }
    for (const world::Row row : moved) {
        if (trigger.notices[e.type[row]] && trigger.holds(e.position[row])) {
            now.push_back(e.id[row]);
        }
    }
    std::sort(now.begin(), now.end());
    now.erase(std::unique(now.begin(), now.end()), now.end());
}

/// Notes the entities of `to` that are not in `from`.
void note(std::size_t trigger,
          bool entered,
          const std::vector<EntityId>& from,
          const std::vector<EntityId>& to,
          TriggerState& triggers) {
    triggers.changed.clear();
    std::set_difference(
        to.begin(), to.end(), from.begin(), from.end(), std::back_inserter(triggers.changed));
    for (const EntityId entity : triggers.changed) {
        triggers.events.push_back({trigger, entity, entered});
    }
}

}  // namespace

void report_triggers(ZoneState& state, RulesContext& context) {
    TriggerState& triggers = state.triggers;
    if (!state.settings.triggers.empty()) {
        collect_moved(state.entities, triggers.moved);
    }
    state.entities.forget_touched(world::Reader::kTriggers);
    if (state.settings.triggers.empty()) {
        return;
    }
    triggers.inside.resize(state.settings.triggers.size());
    triggers.events.clear();
    for (std::size_t i = 0; i < triggers.inside.size(); ++i) {
        std::vector<EntityId>& inside = triggers.inside[i];
        look_into(state, state.settings.triggers[i], inside, triggers.moved, triggers.now);
        note(i, false, triggers.now, inside, triggers);
        note(i, true, inside, triggers.now, triggers);
        std::swap(inside, triggers.now);
    }
    // Only now: what the rules do in a call may move all rows.
    for (const TriggerState::Change& event : triggers.events) {
        state.hash.add(event.entity.value);
        state.hash.add(event.entered);
        state.rules->on_trigger(
            context, {state.settings.triggers[event.trigger].name, event.entity, event.entered});
    }
}

}  // namespace zoned::zone
