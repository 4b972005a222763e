// Weather in the sandbox game: hail that hurts the players in it.
#pragma once

#include "server/rules/game.h"

namespace zoned::rules {

/// Players are hurt by the hail within their reach, each looked at a few times a second in turn.
void hail(Game& game, RulesContext& context);

}  // namespace zoned::rules
