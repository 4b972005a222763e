#include "server/scripting/api/arguments.h"
#include "server/zone/context/stop_context.h"

#include <string>
#include <utility>

namespace zoned::scripting {

namespace {

constexpr std::size_t kStoreUnits = 100;

std::string optional_name(lua_State* lua, int index, const char* name) {
    return lua_isnoneornil(lua, index) ? std::string()
                                       : std::string(name_argument(lua, index, name));
}

/// Whose record it is: the world's, an account's, or that of an account's character.
mailbox::StoreKey record_argument(lua_State* lua, int key, int account) {
    mailbox::StoreKey out;
    out.key = name_argument(lua, key, "key");
    out.account = optional_name(lua, account, "account");
    out.character = optional_name(lua, account + 1, "character");
    luaL_argcheck(lua,
                  out.character.empty() || !out.account.empty(),
                  account,
                  "account: a character is one of an account");
    out.scope = !out.character.empty() ? mailbox::StoreScope::kCharacter
                : !out.account.empty() ? mailbox::StoreScope::kAccount
                                       : mailbox::StoreScope::kWorld;
    return out;
}

/// In on_stop no answer comes: the request has no number, and its target is nobody.
int push_asked(lua_State* lua, bool asked) {
    if (asked) {
        lua_pushinteger(lua, 0);
    } else {
        lua_pushnil(lua);
    }
    return 1;
}

int push_request(lua_State* lua, std::uint64_t number) {
    if (number != 0) {
        lua_pushinteger(lua, static_cast<lua_Integer>(number));
    } else {
        lua_pushnil(lua);
    }
    return 1;
}

/// store_get(target, key [, account [, character]]): the request's number, which on_store is
/// called with in the zone that owns the target; nil: refused.
int get_record(lua_State* lua) {
    Interpreter::charge(lua, kStoreUnits);
    return push_request(
        lua,
        changing(lua).store_get(entity_argument(lua, 1, "target"), record_argument(lua, 2, 3)));
}

/// store_put(target, key, value [, account [, character]])
int put_record(lua_State* lua) {
    Interpreter::charge(lua, kStoreUnits);
    const EntityId target = entity_argument(lua, 1, "target");
    const std::string_view text = text_argument(lua, 3, "value", mailbox::kMaxStoreValueBytes);
    zone::Bytes value(text.begin(), text.end());
    const mailbox::StoreKey key = record_argument(lua, 2, 4);
    if (zone::StopContext* stop = Host::of(lua).stop) {
        return push_asked(lua, stop->store_put(key, std::move(value)));
    }
    return push_request(lua, changing(lua).store_put(target, key, std::move(value)));
}

/// store_remove(target, key [, account [, character]])
int remove_record(lua_State* lua) {
    Interpreter::charge(lua, kStoreUnits);
    const EntityId target = entity_argument(lua, 1, "target");
    const mailbox::StoreKey key = record_argument(lua, 2, 3);
    if (zone::StopContext* stop = Host::of(lua).stop) {
        return push_asked(lua, stop->store_remove(key));
    }
    return push_request(lua, changing(lua).store_remove(target, key));
}

}  // namespace

void open_store(lua_State* lua) {
    constexpr luaL_Reg kFunctions[] = {{"store_get", get_record},
                                       {"store_put", put_record},
                                       {"store_remove", remove_record},
                                       {nullptr, nullptr}};
    luaL_setfuncs(lua, kFunctions, 0);
}

}  // namespace zoned::scripting
