#include "server/zone/census.h"

#include "server/zone/assemblies/motors.h"
#include "server/zone/groups/group_changes.h"
#include "server/zone/simulation/character_movement.h"
#include "server/zone/simulation/moving/zone_doors.h"
#include "server/zone/simulation/moving/zone_platforms.h"
#include "server/zone/simulation/zone_particles.h"
#include "server/zone/simulation/zone_soft_bodies.h"

#include <algorithm>

namespace zoned::zone {

Census take_census(const ZoneState& state, std::size_t inbox_items) {
    Census census;
    const world::Entities& e = state.entities;
    const world::TypeTable& types = *state.settings.types;
    for (std::size_t type = 0; type < e.counts().size(); ++type) {
        const world::Entities::Count& of_type = e.counts()[type];
        census.ghosts += of_type.ghosts;
        census.entities += of_type.owned;
        census.reducible += types[type].reducible() ? of_type.owned : 0U;
        census.characters += types[type].kind == world::EntityKind::kCharacter ? of_type.shown : 0U;
    }
    world::for_each_row(e.stirring(), [&](world::Row row) {
        if (types[e.type[row]].kind == world::EntityKind::kCharacter &&
            !e.has(row, world::kGhost) && !e.has(row, world::kHidden)) {
            census.moving_characters +=
                !e.has(row, world::kAtRest) || wants_to_move(e, row) ? 1U : 0U;
        }
    });
    census.agents = static_cast<std::uint32_t>(state.agents.size());
    census.maps_settled = state.paths.settled();
    census.active_agents = static_cast<std::uint32_t>(state.agents.active().size());
    census.awake_bodies = state.scene.awake_count();
    census.particle_systems = static_cast<std::uint32_t>(state.particles.systems.size());
    census.particles_go_on = particles_go_on(state);
    const SoftCount soft = count_soft(state);
    census.soft_bodies = soft.bodies;
    census.awake_soft = soft.awake;
    census.joints = static_cast<std::uint32_t>(state.assemblies.joints.size());
    census.motors = static_cast<std::uint32_t>(state.assemblies.motors.size());
    census.moving_motors = moving_motors(state);
    census.rigid_soft = soft.rigid;
    census.viewers = static_cast<std::uint32_t>(state.clients.size());
    census.filtered_types = static_cast<std::uint32_t>(
        std::count_if(types.begin(), types.end(), [](const world::EntityType& type) {
            return type.visibility_filter != world::VisibilityFilter::kNothing;
        }));
    census.rewindable_types = static_cast<std::uint32_t>(std::count_if(
        types.begin(), types.end(), [](const world::EntityType& type) { return type.rewindable; }));
    for (const ZoneClient& client : state.clients) {
        const bool audited = (client.rights & mailbox::kRightAudit) != 0;
        census.audited += audited && state.settings.audit.enabled ? 1U : 0U;
    }
    census.inbox = static_cast<std::uint32_t>(inbox_items + state.messages_in.size());
    census.inbox += has_group_changes(state) ? 1U : 0U;
    census.neighbours = static_cast<std::uint32_t>(state.settings.regions.size() - 1);
    census.doors = static_cast<std::uint32_t>(state.doors.body.size());
    census.turning_doors = doors_to_turn(state);
    census.platforms = static_cast<std::uint32_t>(state.platforms.size());
    census.moving_platforms = moving_platforms(state);
    census.rules_busy = state.timers.due(state.now) || state.rules->busy();
    census.ghosts_moved = state.ghosts_moved;
    census.frozen = state.frozen;
    return census;
}

}  // namespace zoned::zone
