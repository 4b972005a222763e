// Push: shoves a prop or a character that is near.
#pragma once

#include "server/rules/game.h"

namespace zoned::rules {

void push(Game& game, RulesContext& context, const Actor& actor, Payload payload);

}  // namespace zoned::rules
