#include "server/rules/machines/vehicles.h"

#include <array>
#include <cmath>

namespace zoned::rules {

namespace {

/// Room between a rider that gets off and the things beside it, m.
constexpr float kBeside = 0.3F;
/// The farthest from the seat that a rider is set down, m.
constexpr float kFarthest = 3.0F;

/// Nothing lies between the seat and the place, nor within a character's radius behind it.
bool is_free(const RulesContext& context, EntityId avatar, const Vec3& seat, const Vec3& place) {
    const Vec3 along = place - seat;
    const world::Row row = context.entities().find(avatar);
    const float radius = context.types()[context.entities().type[row]].character.radius;
    return !context.ray_cast(seat, along.normalized(), along.norm() + radius, avatar).hit;
}

}  // namespace

void ride(Game& game, RulesContext& context, const Actor& actor, Payload payload) {
    sandbox::Ride command;
    if (!command.ParseFromArray(payload.data(), static_cast<int>(payload.size()))) {
        deny_malformed(game, context, actor);
        return;
    }
    if (command.entity() == 0) {
        if (!context.carrier_of(actor.avatar)) {
            deny(game, context, actor, "you ride on nothing");
            return;
        }
        get_off(context, actor.avatar);
        return;
    }
    const world::Entities& entities = context.entities();
    const EntityId part(command.entity());
    const world::Row row = entities.find(part);
    if (row == world::kNoRow || entities.has(row, world::kHidden)) {
        deny(game, context, actor, "no such thing");
        return;
    }
    const float distance = (entities.position[row] - entities.position[actor.row]).norm();
    if (!(distance <= game.settings.ride_range_m)) {
        deny(game, context, actor, "out of reach");
        return;
    }
    const EntityId root = context.assembly_root(part);
    for (std::size_t seat = 0; seat < context.seats_of(root); ++seat) {
        if (context.mount(actor.avatar, root, seat)) {
            context.set_stance(actor.avatar, world::Stance::kRiding);
            ++game.stats.rides;
            return;
        }
    }
    deny(game, context, actor, "no free seat");
}

void get_off(RulesContext& context, EntityId avatar) {
    const world::Entities& entities = context.entities();
    const world::Row row = entities.find(avatar);
    const EntityId carrier = context.carrier_of(avatar);
    const world::Row under = entities.find(carrier);
    const Vec3 seat = entities.position[row];
    const Quat turned = entities.orientation[under];
    const std::array<Vec3, 5> sides{
        Vec3::UnitX(), -Vec3::UnitX(), -Vec3::UnitZ(), Vec3::UnitZ(), Vec3::UnitY()};
    for (float away = 1.0F; away <= kFarthest; away += 0.5F) {
        for (const Vec3& side : sides) {
            const Vec3 place = seat + turned * (side * away) + Vec3(0.0F, kBeside, 0.0F);
            if (is_free(context, avatar, seat, place)) {
                context.dismount(avatar, place);
                return;
            }
        }
    }
    context.dismount(avatar, Vec3(seat + Vec3(0.0F, kFarthest, 0.0F)));
}

}  // namespace zoned::rules
