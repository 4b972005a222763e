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
    const bool is_new = row_of_.insert(entity.value, row);
    ZONED_ASSERT(entity && is_new, "an entity has one row in a zone");
    id.push_back(entity);
    type.values_.push_back(entity_type);
    flags.values_.push_back(0);
    position.emplace_back(Vec3::Zero());
    orientation.emplace_back(Quat::Identity());
    velocity.emplace_back(Vec3::Zero());
    angular_velocity.emplace_back(Vec3::Zero());
    acceleration.emplace_back(Vec3::Zero());
    yaw.push_back(0);
    appearance.push_back(0);
    stance.push_back(0);
    body.emplace_back();
    client.values_.emplace_back();
    command.emplace_back();
    representation.values_.push_back(0);
    discontinuity_tick.push_back(0);
    moving_.push_back(true);
    stirring_.push_back(true);
    avatars_.push_back(false);
    characters_.push_back((traits(entity_type) & kIsCharacter) != 0);
    players_.push_back((traits(entity_type) & kPlayer) != 0);
    rewindable_.push_back((traits(entity_type) & kRewindable) != 0);
    reduced_.push_back(false);
    for (RowSet& touched : touched_) {
        touched.push_back(true);
    }
    fields_.add(entity_type);
    count(entity_type, 0, 1);
    return row;
}

void Entities::remove(Row row) {
    ZONED_ASSERT(row < size(), "a row to remove exists");
    row_of_.erase(id[row].value);
    count(type[row], flags[row], ~std::uint32_t{0});
    fields_.move_last_into(row, type[row]);
    move_last_into(id, row);
    move_last_into(type.values_, row);
    move_last_into(flags.values_, row);
    move_last_into(position, row);
    move_last_into(orientation, row);
    move_last_into(velocity, row);
    move_last_into(angular_velocity, row);
    move_last_into(acceleration, row);
    move_last_into(yaw, row);
    move_last_into(appearance, row);
    move_last_into(stance, row);
    move_last_into(body, row);
    move_last_into(client.values_, row);
    move_last_into(command, row);
    move_last_into(representation.values_, row);
    move_last_into(discontinuity_tick, row);
    moving_.move_last_into(row);
    stirring_.move_last_into(row);
    avatars_.move_last_into(row);
    characters_.move_last_into(row);
    players_.move_last_into(row);
    rewindable_.move_last_into(row);
    reduced_.move_last_into(row);
    for (RowSet& touched : touched_) {
        touched.move_last_into(row);
    }
    if (row < size()) {
        *row_of_.find(id[row].value) = row;
        touch(row);
    }
}

void Entities::set_client(Row row, ClientId to) {
    client.values_[row] = to;
    avatars_.put(row, static_cast<bool>(to));
}

void Entities::set_type(Row row, TypeIndex to) {
    count(type[row], flags[row], ~std::uint32_t{0});
    fields_.set_type(row, type[row], to);
    type.values_[row] = to;
    count(to, flags[row], 1);
    put_by_type(row);
    touch(row);
}

void Entities::set_representation(Row row, std::uint8_t to) {
    representation.values_[row] = to;
    reduced_.put(row, to != 0);
}

void Entities::declare_types(const TypeTable& types) {
    ZONED_ASSERT(size() == 0, "types are declared before the first row");
    traits_.clear();
    for (const EntityType& of : types) {
        const bool character = of.kind == EntityKind::kCharacter;
        std::uint8_t its = 0;
        its |= character ? std::uint8_t{kActsAtRest | kIsCharacter} : std::uint8_t{0};
        its |= character && of.brain == 0 ? std::uint8_t{kPlayer} : std::uint8_t{0};
        its |= of.rewindable ? std::uint8_t{kRewindable} : std::uint8_t{0};
        traits_.push_back(its);
    }
}

/// The sets that follow from a row's type.
void Entities::put_by_type(Row row) {
    stirring_.put(row, stirs(type[row], flags[row]));
    characters_.put(row, (traits(type[row]) & kIsCharacter) != 0);
    players_.put(row, (traits(type[row]) & kPlayer) != 0);
    rewindable_.put(row, (traits(type[row]) & kRewindable) != 0);
}

void Entities::change_flags(Row row, std::uint8_t to) {
    const std::uint8_t before = flags[row];
    flags.values_[row] = to;
    moving_.put(row, (to & kAtRest) == 0);
    stirring_.put(row, stirs(type[row], to));
    if (((before ^ to) & (kGhost | kHidden)) != 0) {
        count(type[row], before, ~std::uint32_t{0});
        count(type[row], to, 1);
    }
    touch(row);
}

bool Entities::find_rows() {
    const std::size_t rows = size();
    const auto fits = [rows](const auto&... column) {
        return ((column.size() == rows) && ...);
    };
    bool fit = fits(type, flags, position, orientation, velocity, angular_velocity, acceleration) &&
               fits(yaw, appearance, stance, body, client, command, representation) &&
               fits(discontinuity_tick, moving_, stirring_, avatars_) && fields_.fits(type.values_);
    for (const RowSet& touched : touched_) {
        fit = fit && fits(touched);
    }
    characters_ = players_ = rewindable_ = reduced_ = RowSet();
    for (Row row = 0; fit && row < rows; ++row) {
        characters_.push_back(false);
        players_.push_back(false);
        rewindable_.push_back(false);
        reduced_.push_back(representation[row] != 0);
        put_by_type(row);
    }
    row_of_.clear();
    for (Row row = 0; fit && row < rows; ++row) {
        fit = id[row] && row_of_.insert(id[row].value, row);
    }
    return fit;
}

/// `more` is 1, or the number that takes one away.
void Entities::count(TypeIndex of, std::uint8_t with, std::uint32_t more) {
    if (of >= counts_.size()) {
        counts_.resize(of + 1U);
    }
    Count& of_type = counts_[of];
    if ((with & kGhost) != 0) {
        of_type.ghosts += more;
        return;
    }
    of_type.owned += more;
    of_type.shown += (with & kHidden) == 0 ? more : 0U;
}

}  // namespace zoned::world
