#include "server/scripting/api/arguments.h"

#include <string>

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
    zone::RulesContext& context = changing(lua);
    Interpreter::charge(lua, kStoreUnits);
    const EntityId target = entity_argument(lua, 1, "target");
    const std::string_view value = text_argument(lua, 3, "value", mailbox::kMaxStoreValueBytes);
    return push_request(
        lua,
        context.store_put(
            target, record_argument(lua, 2, 4), zone::Bytes(value.begin(), value.end())));
}

/// store_remove(target, key [, account [, character]])
int remove_record(lua_State* lua) {
    Interpreter::charge(lua, kStoreUnits);
    return push_request(
        lua,
        changing(lua).store_remove(entity_argument(lua, 1, "target"), record_argument(lua, 2, 3)));
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
