// Combat: damage, bites, hits by thrown props, death by confirmation, and respawning.
#pragma once

#include "server/rules/game.h"

namespace zoned::rules {

/// Hurts a character of this zone or, by a message, of another one.
void hurt(Game& game, RulesContext& context, EntityId target, EntityId by, std::uint32_t amount);
/// The part of hurt() that the owner of the target carries out.
void take_damage(Game& game,
                 RulesContext& context,
                 world::Row row,
                 EntityId by,
                 std::uint32_t amount);

/// Announces the kill of a character of this zone and hides it until it respawns.
void die(Game& game, RulesContext& context, EntityId entity, CharacterRecord& record);

/// Changes the velocity of an entity of this zone or, by a message, of another one. m/s.
void knock(RulesContext& context, EntityId target, const Vec3& change);

/// A thrown prop hurts and knocks the first character that it meets fast enough.
void impact(Game& game, RulesContext& context, const zone::EntityContact& contact);

/// The killed client says that it knows.
void confirm_kill(Game& game, RulesContext& context, ClientId client, EventId event);

/// Runs the timers of one character: unconfirmed death, respawn, its announcement.
void run_life(Game& game, RulesContext& context, EntityId entity, CharacterRecord& record);

/// Lets characters of the biting type bite avatars that they run at.
void bite(Game& game, RulesContext& context);

}  // namespace zoned::rules
