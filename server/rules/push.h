// Push: shoves a prop or a character nearby.
#pragma once

#include "server/rules/game.h"

namespace zoned::rules {

void push(Game& game, RulesContext& context, const Actor& actor, Payload payload);

}  // namespace zoned::rules
