// Entity serialization: the columns of an entity as one value, for the transfer between zones.
#pragma once

#include "server/world/entities.h"
#include "shared/core/ids.h"

#include <cstdint>
#include <vector>

namespace zoned::zone {

/// The columns of one entity; positions are in the coordinates of the zone that wrote it.
struct EntityState {
    EntityId id;
    TypeIndex type = 0;
    std::uint8_t flags = 0;
    std::uint8_t stance = 0;
    std::uint16_t yaw = 0;
    std::uint16_t appearance = 0;
    Vec3 position = Vec3::Zero();
    Quat orientation = Quat::Identity();
    Vec3 velocity = Vec3::Zero();
    Vec3 angular_velocity = Vec3::Zero();
    Vec3 acceleration = Vec3::Zero();
    ClientId client;
    Tick discontinuity_tick = 0;
    std::vector<std::uint32_t> fields;  ///< declared ones: world::FieldColumns::block
};

EntityState read_entity(const world::Entities& entities, world::Row row);
/// Everything but the id and the body; `shift` is added to the position (source origin minus own
/// origin).
void write_entity(const EntityState& state,
                  const Vec3& shift,
                  world::Entities& entities,
                  world::Row row);

}  // namespace zoned::zone
