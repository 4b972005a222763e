#include "server/zone/simulation/character_movement.h"

#include "shared/motion/apply_input.h"
#include "shared/motion/platforms/platform_carry.h"

#include <cmath>

namespace zoned::zone {

namespace {

constexpr float kPatienceSeconds = 1.0F;

/// The kinematic body has to arrive where apply_input says after the step; computed from the body's
/// own position, so that rounding never adds up.
void steer_body(ZoneState& state, world::Row row) {
    world::Entities& e = state.entities;
    if (!e.body[row]) {
        return;
    }
    const physics::BodyState body = state.scene.state(e.body[row]);
    const Vec3 velocity = (e.position[row] - body.position) / state.settings.dt;
    state.scene.set_velocity(e.body[row], velocity, Vec3::Zero());
}

void move_character(ZoneState& state, world::Row row, const world::EntityType& type) {
    world::Entities& e = state.entities;
    const motion::CharacterState before{
        e.position[row], e.velocity[row], e.yaw[row], e.has(row, world::kGrounded)};
    const motion::CharacterState after = motion::apply_input(before,
                                                             e.command[row],
                                                             type.character,
                                                             *state.settings.statics,
                                                             state.settings.dt,
                                                             state.now);
    const bool moved = after.position != before.position || after.velocity != before.velocity ||
                       after.yaw != before.yaw || after.grounded != before.grounded;
    e.position[row] = after.position;
    e.acceleration[row] = (after.velocity - before.velocity) / state.settings.dt;
    e.velocity[row] = after.velocity;
    if (after.yaw != before.yaw) {
        e.yaw[row] = after.yaw;
        e.orientation[row] = motion::orientation_from_yaw(after.yaw);
    }
    e.set(row, world::kGrounded, after.grounded);
    const bool rest = !moved && after.velocity == Vec3::Zero();
    e.set(row, world::kAtRest, rest);
    steer_body(state, row);
}

}  // namespace

bool wants_to_move(const world::Entities& entities, world::Row row) {
    const motion::InputCommand& c = entities.command[row];
    return c.move_x != 0 || c.move_z != 0 || (c.buttons & motion::kButtonJump) != 0 ||
           c.yaw != entities.yaw[row];
}

void take_inputs(ZoneState& state) {
    const auto patience = static_cast<Tick>(std::lround(kPatienceSeconds / state.settings.dt));
    for (ZoneClient& client : state.clients) {
        bool missing = false;
        const motion::InputCommand command = client.inputs.consume(state.now, patience, missing);
        client.own.client = client.client;
        client.own.input_tick = state.now;
        client.own.input_missing = missing;
        client.own.input_lead = client.inputs.lead(state.now);
        const world::Row row = state.entities.find(client.avatar);
        if (row != world::kNoRow) {
            state.entities.command[row] = command;
        }
    }
}

std::uint32_t move_characters(ZoneState& state) {
    world::Entities& e = state.entities;
    const world::TypeTable& types = *state.settings.types;
    const motion::StaticGeometry& statics = *state.settings.statics;
    const bool platforms = !statics.platforms().empty();
    std::uint32_t moved = 0;
    world::for_each_row(e.stirring(), [&](world::Row row) {
        const world::EntityType& type = types[e.type[row]];
        if (type.kind != world::EntityKind::kCharacter || e.has(row, world::kGhost) ||
            e.has(row, world::kHidden) || e.has(row, world::kCarried)) {
            return;
        }
        if (e.has(row, world::kAtRest) && !wants_to_move(e, row) &&
            !(platforms &&
              motion::moved_by_platform(e.position[row], type.character, statics, state.now))) {
            return;
        }
        move_character(state, row, type);
        ++moved;
    });
    state.grid_valid = state.grid_valid && moved == 0;
    return moved;
}

}  // namespace zoned::zone
