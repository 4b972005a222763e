// Tables of the state as scripts see them: an object that stands for a StateTable.
#include "server/scripting/api/arguments.h"
#include "server/scripting/vm/freeze.h"
#include "server/scripting/vm/libraries.h"

#include <optional>
#include <string>
#include <utility>

namespace zoned::scripting {

namespace {

constexpr std::size_t kMaxTextInState = kMaxTextBytes;

// A handle is the table's address: a light userdata, which costs no memory. None outlives the call,
// and StateBudget::removed keeps what is taken out meanwhile.

StateTable& handle(lua_State* lua, int index) {
    return *static_cast<StateTable*>(lua_touserdata(lua, index));
}

void push_handle(lua_State* lua, StateTable& table) {
    lua_pushlightuserdata(lua, &table);
}

/// A table that a script may read now.
StateTable& readable_table(lua_State* lua) {
    reading(lua);
    return handle(lua, 1);
}

std::optional<StateKeyView> state_key_at(lua_State* lua, int index) {
    if (lua_type(lua, index) == LUA_TSTRING) {
        std::size_t size = 0;
        const char* text = lua_tolstring(lua, index, &size);
        return std::string_view(text, size);
    }
    int is_integer = 0;
    const lua_Integer number = lua_tointegerx(lua, index, &is_integer);
    return is_integer != 0 ? std::optional<StateKeyView>(std::int64_t{number}) : std::nullopt;
}

void push_value(lua_State* lua, const StateValue& value) {
    if (const auto* integer = std::get_if<std::int64_t>(&value)) {
        lua_pushinteger(lua, *integer);
    } else if (const auto* number = std::get_if<double>(&value)) {
        lua_pushnumber(lua, *number);
    } else if (const auto* text = std::get_if<std::string>(&value)) {
        push_text(lua, *text);
    } else if (const auto* truth = std::get_if<bool>(&value)) {
        lua_pushboolean(lua, *truth ? 1 : 0);
    } else if (const auto* table = std::get_if<std::shared_ptr<StateTable>>(&value)) {
        push_handle(lua, **table);
    } else {
        lua_pushnil(lua);
    }
}

void push_key(lua_State* lua, const StateKey& key) {
    if (const auto* text = std::get_if<std::string>(&key)) {
        push_text(lua, *text);
    } else {
        lua_pushinteger(lua, std::get<std::int64_t>(key));
    }
}

void keep(lua_State* lua, StateTable& table, const StateKeyView& key, int value);

StateTable& add_table(lua_State* lua, StateTable& table, const StateKeyView& key) {
    StateTable* const below = table.add_table(key).get();
    if (below == nullptr) {
        luaL_error(lua, "state: tables lie more than %d deep", kMaxStateDepth);
    }
    return *below;
}

/// A copy of a table of Lua. Its keys need no order: the state has its own.
void keep_table(lua_State* lua, StateTable& table, const StateKeyView& key, int value) {
    StateTable& below = add_table(lua, table, key);
    luaL_checkstack(lua, 8, "state: tables lie too deep");
    push_entries(lua, value);
    const int entries = lua_gettop(lua);
    for (lua_pushnil(lua); lua_next(lua, entries) != 0; lua_pop(lua, 1)) {
        const auto inner = state_key_at(lua, -2);
        if (!inner) {
            luaL_error(lua, "state: keys are strings or integers, not %s", luaL_typename(lua, -2));
        }
        Interpreter::charge(lua, 2);
        keep(lua, below, *inner, lua_gettop(lua));
    }
    lua_pop(lua, 1);
}

/// A copy of another table of the state.
void keep_copy(lua_State* lua, StateTable& table, const StateKeyView& key, const StateTable& from) {
    StateTable& below = add_table(lua, table, key);
    for (const auto& [inner, value] : from.entries()) {
        Interpreter::charge(lua, 2);
        if (const auto* deeper = std::get_if<std::shared_ptr<StateTable>>(&value)) {
            keep_copy(lua, below, StateKeyLess::view(inner), **deeper);
        } else {
            below.set(StateKeyLess::view(inner), value);
        }
    }
}

void keep(lua_State* lua, StateTable& table, const StateKeyView& key, int value) {
    switch (lua_type(lua, value)) {
        case LUA_TNIL:
            table.set(key, std::monostate());
            return;
        case LUA_TBOOLEAN:
            table.set(key, lua_toboolean(lua, value) != 0);
            return;
        case LUA_TNUMBER:
            if (lua_isinteger(lua, value) != 0) {
                table.set(key, std::int64_t{lua_tointeger(lua, value)});
            } else {
                table.set(key, lua_tonumber(lua, value));
            }
            return;
        case LUA_TSTRING:
            table.set(key, std::string(text_argument(lua, value, "state", kMaxTextInState)));
            return;
        case LUA_TTABLE:
            keep_table(lua, table, key, value);
            return;
        case LUA_TLIGHTUSERDATA:
            keep_copy(lua, table, key, handle(lua, value));
            return;
        default:
            luaL_error(lua, "state: a %s cannot be kept", luaL_typename(lua, value));
    }
}

int get_entry(lua_State* lua) {
    const auto key = state_key_at(lua, 2);
    if (const StateValue* const value = key ? readable_table(lua).find(*key) : nullptr) {
        push_value(lua, *value);
    } else {
        lua_pushnil(lua);
    }
    return 1;
}

int set_entry(lua_State* lua) {
    StateTable& table = readable_table(lua);
    changing(lua);
    const auto key = state_key_at(lua, 2);
    if (!key) {
        return luaL_error(
            lua, "state: keys are strings or integers, not %s", luaL_typename(lua, 2));
    }
    if (!table.attached()) {
        return luaL_error(lua, "state: this table was taken out of the state");
    }
    keep(lua, table, *key, 3);
    return 0;
}

int state_length(lua_State* lua) {
    lua_pushinteger(lua, readable_table(lua).length());
    return 1;
}

/// The entry after a key, in order.
int next_entry(lua_State* lua) {
    const StateTable& table = readable_table(lua);
    const auto key = state_key_at(lua, 2);
    const auto at = key ? table.entries().upper_bound(*key) : table.entries().begin();
    if (at == table.entries().end()) {
        lua_pushnil(lua);
        return 1;
    }
    push_key(lua, at->first);
    push_value(lua, at->second);
    return 2;
}

int entries_of(lua_State* lua) {
    lua_pushcfunction(lua, next_entry);
    lua_pushvalue(lua, 1);
    lua_pushnil(lua);
    return 3;
}

/// entity_state(entity): its own table, which goes with it to other zones; nil where the zone does
/// not own it.
int entity_state(lua_State* lua) {
    const EntityId entity = entity_argument(lua, 1);
    if (owned_row(lua, entity) == world::kNoRow) {
        lua_pushnil(lua);
        return 1;
    }
    StateTable& all = *Host::of(lua).entities;
    const StateKeyView key = std::int64_t{entity.value};
    if (const StateValue* const found = all.find(key)) {
        push_value(lua, *found);
    } else if (Host::of(lua).may_change) {
        push_handle(lua, *all.add_table(key));
    } else {
        lua_newtable(lua);
    }
    return 1;
}

}  // namespace

void open_state(lua_State* lua) {
    lua_pushlightuserdata(lua, Host::of(lua).shared.get());
    lua_newtable(lua);
    constexpr luaL_Reg kMethods[] = {{"__index", get_entry},
                                     {"__newindex", guarded<set_entry>},
                                     {"__len", state_length},
                                     {"__pairs", entries_of},
                                     {nullptr, nullptr}};
    luaL_setfuncs(lua, kMethods, 0);
    lua_setmetatable(lua, -2);  // of all light userdata: there are no others
    lua_setfield(lua, -2, "state");
    lua_pushcfunction(lua, guarded<entity_state>);
    lua_setfield(lua, -2, "entity_state");
}

}  // namespace zoned::scripting
