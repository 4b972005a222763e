// Chat: sends chat by topic, and gives the topics that a client may use.
#pragma once

#include "server/rules/game.h"

namespace zoned::rules {

inline constexpr std::string_view kWorldTopic = "world";
inline constexpr std::size_t kMaxChatBytes = 200;

std::string team_topic(std::string_view team);
std::string zone_topic(ZoneId zone);

/// Publishes a line to the world, the own team or the own zone.
void chat(Game& game, RulesContext& context, const Actor& actor, Payload payload);
/// Turns the world's or the own team's topic on or off. Zone topics follow the avatar by
/// themselves.
void subscribe(Game& game, RulesContext& context, const Actor& actor, Payload payload);

}  // namespace zoned::rules
