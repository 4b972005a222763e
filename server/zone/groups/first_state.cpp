#include "server/zone/groups/first_state.h"

#include "server/zone/assemblies/assembly_spawning.h"
#include "server/zone/assemblies/entity_joints.h"
#include "server/zone/zone_setup.h"
#include "server/zone/zone_state.h"
#include "shared/core/assert.h"

#include <algorithm>

namespace zoned::zone {

void load_maps(ZoneState& state) {
    make_paths(state);
    state.paths.forget_ground();  // it is for paths to other zones
}

void place_first_state(ZoneState& state) {
    load_maps(state);
    const FirstState& first = *state.settings.first_state;
    std::vector<EntityId> spawned;
    for (const FirstState::FirstEntity& placed : first.entities) {
        spawned.push_back(spawn_entity(state, placed.def));
        if (!placed.name.empty()) {
            state.entity_names.insert_or_assign(placed.name, spawned.back());
        }
    }
    const auto end_of = [&](const FirstState::FirstJointEnd& end) {
        return end.entity < 0
                   ? EntityId()
                   : part_id(state, spawned[static_cast<std::size_t>(end.entity)], end.part);
    };
    for (const FirstState::FirstJoint& joint : first.joints) {
        const EntityId a = end_of(joint.a);
        const EntityId b = end_of(joint.b);
        const world::Entities& e = state.entities;
        const auto made = join(state,
                               a,
                               b,
                               (*state.settings.placed_joints)[joint.number],
                               present_frame(e, a ? e.find(a) : world::kNoRow, e.find(b)),
                               {EntityId(), joint.number});
        ZONED_ASSERT(made.ok(), "placed joints were checked when the config was read");
    }
}

void clear_zone(ZoneState& state) {
    std::vector<EntityId> gone;
    const world::Entities& e = state.entities;
    for (world::Row row = 0; row < e.size(); ++row) {
        if (!e.has(row, world::kGhost) && !e.client[row]) {
            gone.push_back(e.id[row]);
        }
    }
    // In an order of their own: that of rows depends on who left before.
    std::sort(gone.begin(), gone.end());
    for (const EntityId id : gone) {
        state.rules->take_entity(id);
        despawn_entity(state, e.find(id));
    }
    state.timers.clear();
    for (const FirstState::FirstEntity& placed : state.settings.first_state->entities) {
        if (!placed.name.empty()) {
            state.entity_names.insert_or_assign(placed.name, EntityId());
        }
    }
    state.paths = ai::PathService();
}

}  // namespace zoned::zone
