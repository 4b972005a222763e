#include "server/scripting/api/arguments.h"
#include "server/zone/groups/rules_matches.h"

#include <cstdint>
#include <limits>

namespace zoned::scripting {

namespace {

// About what these cost, in instructions.
constexpr std::size_t kMatchReadUnits = 20;
constexpr std::size_t kMatchPlayerUnits = 10;
constexpr std::size_t kMatchOrderUnits = 200;

zone::MatchId match_argument(lua_State* lua, int index) {
    return zone::MatchId(static_cast<std::uint32_t>(
        integer_argument(lua, index, "match", 0, std::numeric_limits<std::uint32_t>::max())));
}

/// queue_match(kind, entity): a player waits, or the leader of a party with its members. False
/// where there is no such kind.
int queue_match(lua_State* lua) {
    zone::RulesMatches* const matches = changing(lua).matches();
    const std::string_view kind = name_argument(lua, 1, "kind");
    const EntityId player = entity_argument(lua, 2);
    Interpreter::charge(lua, kMatchOrderUnits);
    return push_done(lua, matches != nullptr && matches->queue(kind, player));
}

/// unqueue_match(entity): with all that wait with it.
int unqueue_match(lua_State* lua) {
    zone::RulesMatches* const matches = changing(lua).matches();
    const EntityId player = entity_argument(lua, 1);
    Interpreter::charge(lua, kMatchOrderUnits);
    return push_done(lua, matches != nullptr && matches->unqueue(player));
}

/// end_match(match [, event, result]): its players get the result as a durable event of that kind.
int end_match(lua_State* lua) {
    zone::RulesMatches* const matches = changing(lua).matches();
    const zone::MatchId match = match_argument(lua, 1);
    const bool has_result = !lua_isnoneornil(lua, 2);
    const auto event = static_cast<std::uint16_t>(
        has_result ? integer_argument(lua, 2, "event", zone::kFirstRulesEvent, 0xFFFF) : 0);
    const std::string_view result = lua_isnoneornil(lua, 3)
                                        ? std::string_view()
                                        : text_argument(lua, 3, "result", zone::kMostResultBytes);
    Interpreter::charge(lua, kMatchOrderUnits);
    return push_done(
        lua,
        matches != nullptr &&
            matches->end(match,
                         event,
                         {reinterpret_cast<const std::uint8_t*>(result.data()), result.size()}));
}

/// match_of(entity): nil where the player is in no match.
int match_of(lua_State* lua) {
    const zone::RulesMatches* const matches = reading(lua).matches();
    const EntityId player = entity_argument(lua, 1);
    Interpreter::charge(lua, kMatchReadUnits);
    const zone::MatchId match = matches != nullptr ? matches->of(player) : zone::MatchId();
    if (match) {
        lua_pushinteger(lua, match.value);
    } else {
        lua_pushnil(lua);
    }
    return 1;
}

void push_player(lua_State* lua, const zone::MatchPlayer& player) {
    lua_newtable(lua);
    push_entity(lua, player.avatar);
    lua_setfield(lua, -2, "entity");
    lua_pushinteger(lua, player.client.value);
    lua_setfield(lua, -2, "client");
    lua_pushinteger(lua, player.team + 1);
    lua_setfield(lua, -2, "team");
    lua_pushboolean(lua, player.here ? 1 : 0);
    lua_setfield(lua, -2, "here");
    lua_pushboolean(lua, player.lost ? 1 : 0);
    lua_setfield(lua, -2, "lost");
}

/// match_players(match): { entity =, client =, team =, here =, lost = } each; teams count from 1.
/// Nil where there is no such match.
int match_players(lua_State* lua) {
    const zone::RulesMatches* const matches = reading(lua).matches();
    const zone::MatchId id = match_argument(lua, 1);
    const zone::Match* const match = matches != nullptr ? matches->find(id) : nullptr;
    if (match == nullptr) {
        Interpreter::charge(lua, kMatchReadUnits);
        lua_pushnil(lua);
        return 1;
    }
    Interpreter::charge(lua, kMatchReadUnits + kMatchPlayerUnits * match->players.size());
    lua_newtable(lua);
    lua_Integer n = 0;
    for (const zone::MatchPlayer& player : match->players) {
        push_player(lua, player);
        lua_rawseti(lua, -2, ++n);
    }
    return 1;
}

/// match_topic(match)
int match_topic(lua_State* lua) {
    push_text(lua, zone::match_topic(match_argument(lua, 1)));
    return 1;
}

}  // namespace

void open_matches(lua_State* lua) {
    constexpr luaL_Reg kFunctions[] = {{"queue_match", queue_match},
                                       {"unqueue_match", unqueue_match},
                                       {"end_match", end_match},
                                       {"match_of", match_of},
                                       {"match_players", match_players},
                                       {"match_topic", match_topic},
                                       {nullptr, nullptr}};
    luaL_setfuncs(lua, kFunctions, 0);
}

}  // namespace zoned::scripting
