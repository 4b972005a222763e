// Zone soft bodies: the entities of a zone whose type is a soft body.
#pragma once

#include "server/zone/zone_state.h"

#include <cstdint>

namespace zoned::zone {

/// The zone's soft bodies; made empty with the first call.
SoftMatter& soft_matter(ZoneState& state);

/// True for an entity whose type is a soft body, owned or a ghost.
bool is_soft(const ZoneState& state, world::Row row);

/// Null where soft_of is none. Valid until a soft body comes or goes.
SoftLink* soft_link(const ZoneState& state, EntityId entity);

/// The body of an owned entity; none where it is rigid, hidden or not here.
physics::soft::SoftId soft_of(const ZoneState& state, EntityId entity);

/// Gives an owned entity the body of its type, whole and as it is defined, turned, placed and
/// moving as the columns say (pinned nodes stay).
void add_soft(ZoneState& state, world::Row row, bool asleep);
void remove_soft(ZoneState& state, EntityId entity);

/// Adds a velocity to all nodes that are not pinned.
void push_soft(ZoneState& state, world::Row row, const Vec3& change);
/// Moves all nodes to where the columns say, at rest, as deformed as they are.
void place_soft(ZoneState& state, world::Row row);

/// The body for the transfer to another zone, or an empty parcel; and back. `shift` as in
/// write_entity.
physics::soft::SoftParcel take_soft(ZoneState& state, EntityId entity);
void give_soft(ZoneState& state,
               world::Row row,
               physics::soft::SoftParcel parcel,
               const Vec3& shift);

/// One step of all awake soft bodies, with the rigid bodies where they are now. The rigid bodies
/// are stepped afterwards. The columns take the centre of mass and its velocity, and the turn that
/// fits best (see SoftBodies::best_fit_turn). They also take the rate of this turn, by which
/// clients predict it. Returns the number of bodies that were awake.
std::uint32_t step_soft(ZoneState& state);

struct SoftCount {
    std::uint32_t bodies = 0;
    std::uint32_t awake = 0;  ///< as soft bodies
    std::uint32_t rigid = 0;  ///< stepped down to their hulls
};

SoftCount count_soft(const ZoneState& state);

void hash_soft(const ZoneState& state, core::StateHash& hash);

}  // namespace zoned::zone
