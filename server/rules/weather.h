// Particles in the sandbox game: debris that hits throw up, and hail that hurts who stands in it.
#pragma once

#include "server/rules/game.h"

namespace zoned::rules {

/// Debris flies off a surface at `point` along its outward `normal`, where the world has such a
/// system: cosmetic, clients are told; simulated, nobody is.
void throw_debris(const Game& game, RulesContext& context, const Vec3& point, const Vec3& normal);

/// Players are hurt by the hail within their reach, each looked at a few times a second in turn.
void hail(Game& game, RulesContext& context);

}  // namespace zoned::rules
