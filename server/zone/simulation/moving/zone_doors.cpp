#include "server/zone/simulation/moving/zone_doors.h"

#include "server/zone/simulation/type_body.h"
#include "shared/core/assert.h"
#include "shared/motion/apply_input.h"

#include <algorithm>

namespace zoned::zone {

namespace {

/// Bodies this near to a door that shuts may have leant on nothing until now, m.
constexpr float kTouch = 0.02F;

const Aabb& bounds_of(const motion::StaticGeometry& statics, std::uint32_t door) {
    return statics.box_bounds(static_cast<std::uint32_t>(statics.boxes().size()) + door);
}

void shut(ZoneState& state, std::uint32_t door) {
    const motion::StaticBox& box = state.settings.statics->doors()[door].box;
    physics::BodyDef def;
    def.kind = physics::BodyKind::kStatic;
    def.shape = physics::Shape::box(box.half_extents);
    def.position = box.centre;
    def.orientation = box.orientation;
    def.material = {box.friction, box.restitution};
    def.filter.category = kMovingCategory;
    const auto body = state.scene.add(def);
    ZONED_ASSERT(body.ok(), "doors were checked when the config was read");
    state.doors.body[door] = *body;
    state.bodies_near.clear();
    state.scene.overlap(bounds_of(*state.settings.statics, door).grown(kTouch), state.bodies_near);
    for (const BodyId near : state.bodies_near) {
        state.scene.wake(near);
    }
}

void open(ZoneState& state, std::uint32_t door) {
    state.scene.remove(state.doors.body[door]);
    state.doors.body[door] = BodyId();
}

/// Characters that rest where a door has turned move again, if only out of it. Agents that are
/// simulated off-screen are placed by their own means.
void wake_resting(ZoneState& state) {
    world::Entities& e = state.entities;
    world::for_each_row(e.stirring(), [&](world::Row row) {
        const world::EntityType& type = (*state.settings.types)[e.type[row]];
        if (type.kind == world::EntityKind::kCharacter && e.has(row, world::kAtRest) &&
            !e.has(row, world::kGhost) && !e.has(row, world::kHidden) &&
            motion::moved_by_door(
                e.position[row], type.character, *state.settings.statics, state.now)) {
            e.set(row, world::kAtRest, false);
        }
    });
}

bool stands_other(const ZoneState& state, std::uint32_t door) {
    const bool is_shut = static_cast<bool>(state.doors.body[door]);
    return state.settings.statics->shut_at(door, state.now) != is_shut;
}

}  // namespace

void add_doors(ZoneState& state) {
    state.doors.body.resize(state.settings.statics->doors().size());
    turn_doors(state);
}

std::uint32_t doors_to_turn(const ZoneState& state) {
    if (state.doors.body.empty() || state.now < state.doors.next_turn) {
        return 0;
    }
    std::uint32_t count = 0;
    for (std::uint32_t door = 0; door < state.doors.body.size(); ++door) {
        count += stands_other(state, door) ? 1U : 0U;
    }
    return count;
}

std::uint32_t turn_doors(ZoneState& state) {
    std::uint32_t turned = 0;
    state.doors.next_turn = state.settings.statics->next_turn(state.now);
    for (std::uint32_t door = 0; door < state.doors.body.size(); ++door) {
        if (stands_other(state, door)) {
            state.doors.body[door] ? open(state, door) : shut(state, door);
            ++turned;
        }
    }
    if (turned > 0) {
        wake_resting(state);
    }
    return turned;
}

}  // namespace zoned::zone
