// Assembly spawning: the parts and joints of a type of several bodies come into a zone and leave
// it.
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

/// Adds the parts of a root that has just been spawned, and the joints between them. The parts
/// move as one rigid body with the root.
void spawn_parts(ZoneState& state, EntityId root);

}  // namespace zoned::zone
