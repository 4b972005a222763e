// Kept character: what the store knows of a player's character: its inventory and its score.
#pragma once

#include "server/rules/game.h"

namespace zoned::rules {

/// Asks the store for what it kept of a character that has just joined. A client without an account
/// keeps nothing.
void ask_for_kept(RulesContext& context, EntityId avatar, CharacterRecord& record);

/// Has the store keep the character as it is now. Until the store has answered ask_for_kept() it
/// waits, so that nothing that was kept before is overwritten.
void keep(RulesContext& context, EntityId avatar, CharacterRecord& record);

/// Whether the store has, or will have, what the character owns: it may leave with it.
[[nodiscard]] bool is_kept(const CharacterRecord& record);

/// The store's answer to either.
void on_kept(Game& game, RulesContext& context, const mailbox::StoreAnswer& answer);

}  // namespace zoned::rules
