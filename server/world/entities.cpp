#include "server/world/entities.h"

#include "shared/core/assert.h"

namespace zoned::world {

namespace {

template <class Column>
void move_last_into(Column& column, Row row) {
    column[row] = column.back();
    column.pop_back();
}

}  // namespace

Row Entities::add(EntityId entity, TypeIndex entity_type) {
    const Row row = static_cast<Row>(size());
    const bool is_new = row_of_.emplace(entity, row).second;
    ZONED_ASSERT(entity && is_new, "an entity has one row in a zone");
    id.push_back(entity);
    type.push_back(entity_type);
    flags.push_back(0);
    position.emplace_back(Vec3::Zero());
    orientation.emplace_back(Quat::Identity());
    velocity.emplace_back(Vec3::Zero());
    angular_velocity.emplace_back(Vec3::Zero());
    acceleration.emplace_back(Vec3::Zero());
    yaw.push_back(0);
    appearance.push_back(0);
    behaviour.push_back(0);
    body.emplace_back();
    client.emplace_back();
    command.emplace_back();
    representation.push_back(0);
    discontinuity_tick.push_back(0);
    return row;
}

void Entities::remove(Row row) {
    ZONED_ASSERT(row < size(), "a row to remove exists");
    row_of_.erase(id[row]);
    move_last_into(id, row);
    move_last_into(type, row);
    move_last_into(flags, row);
    move_last_into(position, row);
    move_last_into(orientation, row);
    move_last_into(velocity, row);
    move_last_into(angular_velocity, row);
    move_last_into(acceleration, row);
    move_last_into(yaw, row);
    move_last_into(appearance, row);
    move_last_into(behaviour, row);
    move_last_into(body, row);
    move_last_into(client, row);
    move_last_into(command, row);
    move_last_into(representation, row);
    move_last_into(discontinuity_tick, row);
    if (row < size()) {
        row_of_[id[row]] = row;
    }
}

Row Entities::find(EntityId entity) const {
    const auto it = row_of_.find(entity);
    return it == row_of_.end() ? kNoRow : it->second;
}

}  // namespace zoned::world
