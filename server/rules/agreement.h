// Agreement: sends facts that must not diverge (deaths, kills, trades) to the clients concerned
// until they hold the same.
#pragma once

#include "server/rules/game.h"

namespace zoned::rules {

/// A decision changed this player's inventory or state. The whole of it is sent now and again every
/// `agree_repeat_s` until the client confirms the same state. This is repeated state regeneration:
/// it repairs any difference between two clients. Given up, and counted, after kMostRepeats.
void decided(Game& game, RulesContext& context, EntityId avatar, CharacterRecord& record);

/// The character has become what the store kept of it: its client takes all of it over.
void restored(Game& game, RulesContext& context, EntityId avatar, CharacterRecord& record);

/// Sends again the decisions that are due.
void run_agreement(Game& game, RulesContext& context, CharacterRecord& record);

/// The client's report of its digest. A digest that differs from the server's is counted. The
/// client is then ordered to take over the server's state, and its view is reset.
void agree(Game& game, RulesContext& context, const Actor& actor, Payload payload);

/// An offer to a player of this zone within reach: an item for an item. It stands for
/// `offer_s`; a player has one at a time.
void offer(Game& game, RulesContext& context, const Actor& actor, Payload payload);

/// Takes an offer as it was made: both items change hands at once, or nothing does. Both clients
/// are notified and confirm.
void accept(Game& game, RulesContext& context, const Actor& actor, Payload payload);

}  // namespace zoned::rules
