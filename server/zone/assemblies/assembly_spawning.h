// Assembly spawning: entities come into a zone and leave it, those of several bodies with all parts
// and joints.
#pragma once

#include "server/zone/zone_state.h"

namespace zoned::zone {

/// The id of a part of the assembly with this root. All parts get their ids one after the other.
EntityId part_id(const ZoneState& state, EntityId root, std::uint16_t part);
/// The assembly whose root an entity of this zone is, or nullptr.
const AssemblyDef* assembly_of(const ZoneState& state, EntityId root);
/// The root of the assembly that a part belongs to, if the root is in this zone; an entity that is
/// no part is its own root.
EntityId root_of(const ZoneState& state, EntityId part);

/// Spawns an owned entity: row, body, agent; with the root of an assembly all its parts. Works
/// before the first tick as well.
EntityId spawn_entity(ZoneState& state, const SpawnDef& def);
/// Removes row, body, agent, joints and rides of an owned entity.
void despawn_entity(ZoneState& state, world::Row row);

}  // namespace zoned::zone
