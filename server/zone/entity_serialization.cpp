#include "server/zone/entity_serialization.h"

namespace zoned::zone {

EntityState read_entity(const world::Entities& entities, world::Row row) {
    EntityState s;
    s.id = entities.id[row];
    s.type = entities.type[row];
    s.flags = entities.flags[row];
    s.stance = entities.stance[row];
    s.yaw = entities.yaw[row];
    s.appearance = entities.appearance[row];
    s.position = entities.position[row];
    s.orientation = entities.orientation[row];
    s.velocity = entities.velocity[row];
    s.angular_velocity = entities.angular_velocity[row];
    s.acceleration = entities.acceleration[row];
    s.client = entities.client[row];
    s.discontinuity_tick = entities.discontinuity_tick[row];
    const auto fields = entities.fields().block(row, s.type);
    s.fields.assign(fields.begin(), fields.end());
    return s;
}

void write_entity(const EntityState& state,
                  const Vec3& shift,
                  world::Entities& entities,
                  world::Row row) {
    entities.set_type(row, state.type);
    entities.set_flags(row, state.flags);
    entities.stance[row] = state.stance;
    entities.yaw[row] = state.yaw;
    entities.appearance[row] = state.appearance;
    entities.position[row] = state.position + shift;
    entities.orientation[row] = state.orientation;
    entities.velocity[row] = state.velocity;
    entities.angular_velocity[row] = state.angular_velocity;
    entities.acceleration[row] = state.acceleration;
    entities.set_client(row, state.client);
    entities.discontinuity_tick[row] = state.discontinuity_tick;
    entities.put_field_block(row, state.fields);
    entities.touch(row);
}

}  // namespace zoned::zone
