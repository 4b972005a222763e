#include "server/scripting/api/arguments.h"
#include "server/zone/groups/rules_parties.h"

#include <cstdint>
#include <limits>

namespace zoned::scripting {

namespace {

// About what these cost, in instructions.
constexpr std::size_t kPartyReadUnits = 20;
constexpr std::size_t kPartyMemberUnits = 10;
constexpr std::size_t kPartyOrderUnits = 200;

zone::PartyId party_argument(lua_State* lua, int index) {
    return zone::PartyId(static_cast<std::uint32_t>(
        integer_argument(lua, index, "party", 0, std::numeric_limits<std::uint32_t>::max())));
}

/// Nil for none.
void push_party(lua_State* lua, zone::PartyId party) {
    if (party) {
        lua_pushinteger(lua, party.value);
    } else {
        lua_pushnil(lua);
    }
}

template <class Value>
void set_integer(lua_State* lua, const char* field, Value value) {
    lua_pushinteger(lua, static_cast<lua_Integer>(value));
    lua_setfield(lua, -2, field);
}

/// party_of(entity): the party of a player; nil where it is in none.
int party_of(lua_State* lua) {
    const zone::RulesParties* const parties = reading(lua).parties();
    const EntityId player = entity_argument(lua, 1);
    Interpreter::charge(lua, kPartyReadUnits);
    push_party(lua, parties != nullptr ? parties->of(player) : zone::PartyId());
    return 1;
}

void push_member(lua_State* lua, const zone::PartyMember& member) {
    lua_newtable(lua);
    push_entity(lua, member.player.avatar);
    lua_setfield(lua, -2, "entity");
    push_text(lua, member.player.name);
    lua_setfield(lua, -2, "name");
    lua_pushboolean(lua, member.is_away() ? 1 : 0);
    lua_setfield(lua, -2, "away");
    if (!member.is_away()) {
        set_integer(lua, "client", member.player.client.value);
        set_integer(lua, "zone", member.player.zone.value);
    }
}

/// party_members(party): { entity =, name =, away =, client =, zone = } each, the leader first; nil
/// where there is no such party.
int party_members(lua_State* lua) {
    const zone::RulesParties* const parties = reading(lua).parties();
    const zone::PartyId id = party_argument(lua, 1);
    const zone::Party* const party = parties != nullptr ? parties->find(id) : nullptr;
    if (party == nullptr) {
        Interpreter::charge(lua, kPartyReadUnits);
        lua_pushnil(lua);
        return 1;
    }
    Interpreter::charge(lua, kPartyReadUnits + kPartyMemberUnits * party->members.size());
    lua_newtable(lua);
    lua_Integer n = 0;
    for (const zone::PartyMember& member : party->members) {
        push_member(lua, member);
        lua_rawseti(lua, -2, ++n);
    }
    return 1;
}

/// party_invitations(entity): the parties that invite a player.
int party_invitations(lua_State* lua) {
    const zone::RulesParties* const parties = reading(lua).parties();
    const EntityId player = entity_argument(lua, 1);
    Interpreter::charge(lua, kPartyReadUnits + kPartyMemberUnits * zone::kMostInvitationsTo);
    lua_newtable(lua);
    if (parties == nullptr) {
        return 1;
    }
    std::vector<zone::PartyId>& found = Host::of(lua).parties;
    found.clear();
    parties->invitations_of(player, found);
    lua_Integer n = 0;
    for (const zone::PartyId party : found) {
        push_party(lua, party);
        lua_rawseti(lua, -2, ++n);
    }
    return 1;
}

/// party_topic(party)
int party_topic(lua_State* lua) {
    push_text(lua, zone::party_topic(party_argument(lua, 1)));
    return 1;
}

/// party_value(party, key): nil where nothing is kept there.
int party_value(lua_State* lua) {
    const zone::RulesParties* const parties = reading(lua).parties();
    const zone::PartyId party = party_argument(lua, 1);
    const std::string_view key = name_argument(lua, 2, "key");
    Interpreter::charge(lua, kPartyReadUnits + kPartyMemberUnits);
    const auto value = parties != nullptr ? parties->value(party, key) : std::nullopt;
    if (value) {
        push_text(lua, {reinterpret_cast<const char*>(value->data()), value->size()});
    } else {
        lua_pushnil(lua);
    }
    return 1;
}

/// set_party_value(party, key, value): behind this tick; "" or nil takes the key away.
int set_party_value(lua_State* lua) {
    zone::RulesParties* const parties = changing(lua).parties();
    const zone::PartyId party = party_argument(lua, 1);
    const std::string_view key = name_argument(lua, 2, "key");
    const std::string_view value = lua_isnoneornil(lua, 3)
                                       ? std::string_view()
                                       : text_argument(lua, 3, "value", zone::kMostPartyValueBytes);
    Interpreter::charge(lua, kPartyOrderUnits);
    return push_done(
        lua,
        parties != nullptr &&
            parties->set_value(
                party, key, {reinterpret_cast<const std::uint8_t*>(value.data()), value.size()}));
}

/// Of a player on another, named by their avatars.
template <bool (zone::RulesParties::*Act)(EntityId, EntityId)>
int act_on_player(lua_State* lua) {
    zone::RulesParties* const parties = changing(lua).parties();
    const EntityId by = entity_argument(lua, 1);
    const EntityId other = entity_argument(lua, 2, "other");
    Interpreter::charge(lua, kPartyOrderUnits);
    return push_done(lua, parties != nullptr && (parties->*Act)(by, other));
}

template <bool (zone::RulesParties::*Act)(EntityId, zone::PartyId)>
int answer_party(lua_State* lua) {
    zone::RulesParties* const parties = changing(lua).parties();
    const EntityId guest = entity_argument(lua, 1);
    const zone::PartyId party = party_argument(lua, 2);
    Interpreter::charge(lua, kPartyOrderUnits);
    return push_done(lua, parties != nullptr && (parties->*Act)(guest, party));
}

template <bool (zone::RulesParties::*Act)(EntityId)>
int act_alone(lua_State* lua) {
    zone::RulesParties* const parties = changing(lua).parties();
    const EntityId by = entity_argument(lua, 1);
    Interpreter::charge(lua, kPartyOrderUnits);
    return push_done(lua, parties != nullptr && (parties->*Act)(by));
}

}  // namespace

void open_parties(lua_State* lua) {
    using zone::RulesParties;
    constexpr luaL_Reg kFunctions[] = {{"party_of", party_of},
                                       {"party_members", party_members},
                                       {"party_invitations", party_invitations},
                                       {"party_topic", party_topic},
                                       {"party_value", party_value},
                                       {"set_party_value", set_party_value},
                                       {"party_invite", act_on_player<&RulesParties::invite>},
                                       {"party_accept", answer_party<&RulesParties::accept>},
                                       {"party_decline", answer_party<&RulesParties::decline>},
                                       {"party_leave", act_alone<&RulesParties::leave>},
                                       {"party_kick", act_on_player<&RulesParties::kick>},
                                       {"party_promote", act_on_player<&RulesParties::promote>},
                                       {"party_disband", act_alone<&RulesParties::disband>},
                                       {nullptr, nullptr}};
    luaL_setfuncs(lua, kFunctions, 0);
}

}  // namespace zoned::scripting
