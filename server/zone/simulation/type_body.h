// Type body: an entity type as the physics sees it.
#pragma once

#include "server/physics/shapes/shape.h"
#include "server/world/entity_type.h"

#include <cstdint>
#include <span>

namespace zoned::zone {

/// Bodies of rewindable types are in this category, all others are not.
inline constexpr std::uint32_t kRewindableCategory = 1u << 1;

/// Bodies of doors and platforms are in this category, all others are not.
inline constexpr std::uint32_t kMovingCategory = 1u << 2;

/// Bodies of parts of assemblies are in one of these, the second if rewindable; all others are not.
inline constexpr std::uint32_t kPartCategory = 1u << 3;
inline constexpr std::uint32_t kRewindablePartCategory = 1u << 4;

/// The bodies that one of an entity of the type meets.
physics::Filter filter_of(const world::EntityType& type);

/// The body that an owned entity of the type has: shape, material, mass and kind (dynamic for
/// props, kinematic for characters), at rest at the origin. `solids`: see ZoneSettings. A soft
/// type, whose entities have no rigid body, gives the box around it as it is defined.
physics::BodyDef body_of(const world::EntityType& type, std::span<const physics::Shape> solids);

}  // namespace zoned::zone
