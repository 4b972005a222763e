#include "server/rules/machines/ragdolls.h"

#include <algorithm>

namespace zoned::rules {

void fall_as_ragdoll(Game& game, RulesContext& context, EntityId character) {
    const world::Row row = owned_row(context, character);
    if (game.settings.ragdoll_type.empty() || row == world::kNoRow) {
        return;
    }
    const world::Entities& entities = context.entities();
    zone::SpawnDef def;
    def.type = context.type_named(game.settings.ragdoll_type);
    const world::EntityType& standing = context.types()[entities.type[row]];
    const world::EntityType& lying = context.types()[def.type];
    // Its feet begin where the character's are, not below.
    const float lift = -lying.standing.lower.y() - (standing.radius + standing.half_segment);
    def.position = entities.position[row] + std::max(0.0F, lift) * Vec3::UnitY();
    def.orientation = (entities.orientation[row] * lying.stands).normalized();
    def.velocity = entities.velocity[row];
    const EntityId ragdoll = context.spawn(def);
    game.ragdolls[ragdoll].gone_at = context.now() + ticks(context, game.settings.ragdoll_s);
    update_pending(game, ragdoll);
}

bool run_ragdoll(RulesContext& context, EntityId ragdoll, const RagdollRecord& record) {
    if (context.now() < record.gone_at) {
        return true;
    }
    if (owned_row(context, ragdoll) != world::kNoRow) {
        context.despawn(ragdoll);
    }
    return false;
}

}  // namespace zoned::rules
