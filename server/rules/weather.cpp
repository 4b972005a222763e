#include "server/rules/weather.h"

#include "server/rules/combat.h"

#include <algorithm>
#include <cmath>

namespace zoned::rules {

namespace {

constexpr float kHailEvery_s = 0.25F;  ///< avatars take turns: each is looked at so often
constexpr float kHailReach_m = 1.0F;

}  // namespace

void hail(Game& game, RulesContext& context) {
    if (game.settings.hail_system.empty() || game.settings.hail_damage <= 0.0F) {
        return;
    }
    const Tick every = ticks(context, kHailEvery_s);
    for (const auto& [client, avatar] : game.avatars) {
        const bool turn = (context.now() + static_cast<Tick>(avatar.value)) % every == 0;
        const world::Row row = turn ? owned_row(context, avatar) : world::kNoRow;
        if (row == world::kNoRow || game.characters.at(avatar).life != Life::kAlive) {
            continue;
        }
        const std::uint32_t stones = context.particles_near(
            game.settings.hail_system, context.entities().position[row], kHailReach_m);
        const auto damage = static_cast<std::uint32_t>(std::lround(std::min(
            static_cast<float>(stones) * game.settings.hail_damage, game.settings.health)));
        if (damage > 0) {
            take_damage(game, context, row, EntityId(), damage);
        }
    }
}

}  // namespace zoned::rules
