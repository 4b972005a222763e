#include "server/rules/push.h"

#include "server/rules/combat.h"

namespace zoned::rules {

void push(Game& game, RulesContext& context, const Actor& actor, Payload payload) {
    sandbox::Push command;
    if (!command.ParseFromArray(payload.data(), static_cast<int>(payload.size()))) {
        deny_malformed(game, context, actor);
        return;
    }
    const EntityId target(command.entity());
    const world::Entities& entities = context.entities();
    const world::Row row = target ? entities.find(target) : world::kNoRow;
    if (row == world::kNoRow || entities.has(row, world::kHidden) || target == actor.avatar) {
        deny(game, context, actor, "no such thing");
        return;
    }
    const Vec3 offset = entities.position[row] - entities.position[actor.row];
    if (!(offset.norm() <= game.settings.push_range_m)) {
        deny(game, context, actor, "out of reach");
        return;
    }
    if (context.now() < actor.record->next_push) {
        deny(game, context, actor, "too fast");
        return;
    }
    actor.record->next_push = context.now() + ticks(context, game.settings.push_cooldown_s);
    // An entity straight above or below is pushed in the direction in which the pusher looks.
    Vec3 away(offset.x(), 0.0F, offset.z());
    if (away.norm() < 1e-3F) {
        away = entities.orientation[actor.row] * Vec3::UnitZ();
    }
    knock(context, target, away.normalized() * game.settings.push_mps);
    ++game.stats.pushes;
}

}  // namespace zoned::rules
