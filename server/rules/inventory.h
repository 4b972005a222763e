// Inventory: picking up (also across a border), throwing, dropping.
#pragma once

#include "server/rules/game.h"
#include "server/rules/peer_messages.h"

namespace zoned::rules {

/// A carried prop is no entity: it is despawned where it was picked up. The inventory keeps its
/// type, appearance and, as a handle, its former id; a throw spawns a new entity. So items travel
/// with their carrier through any handoff.
void pick_up(Game& game, RulesContext& context, const Actor& actor, Payload payload);
void throw_item(Game& game, RulesContext& context, const Actor& actor, Payload payload);
/// The client hears what its character carries; with an account, when that is durable.
void send_inventory(RulesContext& context, const CharacterRecord& record);
/// Puts all items down in a ring around the avatar.
void drop_inventory(RulesContext& context, world::Row avatar, CharacterRecord& record);

// A pick-up across a border takes three steps, so that the item is never lost and never doubled:
//
//   1. The picker's zone sends a request.
//   2. The prop's zone hides and reserves the prop, and grants it.
//   3. The picker's zone stores it and says done; the prop's zone then despawns it.
//
// Without an answer the prop comes back.
void on_pick_request(Game& game, RulesContext& context, EntityId item, const PickRequest& request);
void on_pick_grant(Game& game, RulesContext& context, EntityId picker, const PickGrant& grant);
void on_pick_refusal(Game& game, RulesContext& context, EntityId picker);
void on_pick_done(Game& game, RulesContext& context, EntityId item, const PickDone& done);

/// Runs the timers of one prop. Returns false when nothing remains to be remembered of it.
bool run_prop(Game& game, RulesContext& context, EntityId entity, PropRecord& record);

}  // namespace zoned::rules
