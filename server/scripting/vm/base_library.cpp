#include "server/scripting/vm/freeze.h"
#include "server/scripting/vm/libraries.h"

#include <algorithm>
#include <cstring>
#include <vector>

namespace zoned::scripting {

namespace {

constexpr lua_Integer kMostLevels = 100;
constexpr std::size_t kTextBytesPerWork = 16;
/// A table that was emptied may be as large as before.
constexpr std::size_t kPairsUnits = 100;

/// A key of a table: integers come first, then numbers, texts, false and true.
struct SortKey {
    enum class Kind : std::uint8_t {
        kInteger,
        kNumber,
        kText,
        kTruth
    };

    Kind kind = Kind::kInteger;
    lua_Integer integer = 0;  // truth values too
    lua_Number number = 0;
    const char* text = nullptr;  // the table keeps it
    std::size_t length = 0;

    bool operator<(const SortKey& other) const {
        if (kind != other.kind) {
            return kind < other.kind;
        }
        if (kind == Kind::kNumber) {
            return number < other.number;
        }
        if (kind == Kind::kText) {
            const int order = std::memcmp(text, other.text, std::min(length, other.length));
            return order != 0 ? order < 0 : length < other.length;
        }
        return integer < other.integer;
    }
};

SortKey sort_key_at(lua_State* lua, int index) {
    SortKey key;
    switch (lua_type(lua, index)) {
        case LUA_TNUMBER:
            key.kind =
                lua_isinteger(lua, index) != 0 ? SortKey::Kind::kInteger : SortKey::Kind::kNumber;
            key.integer = lua_tointeger(lua, index);
            key.number = lua_tonumber(lua, index);
            return key;
        case LUA_TSTRING:
            key.kind = SortKey::Kind::kText;
            key.text = lua_tolstring(lua, index, &key.length);
            return key;
        case LUA_TBOOLEAN:
            key.kind = SortKey::Kind::kTruth;
            key.integer = lua_toboolean(lua, index);
            return key;
        default:
            luaL_error(lua,
                       "pairs: a table with a %s as key has no order",
                       lua_typename(lua, lua_type(lua, index)));
            return key;
    }
}

void push_sort_key(lua_State* lua, const SortKey& key) {
    switch (key.kind) {
        case SortKey::Kind::kInteger:
            lua_pushinteger(lua, key.integer);
            return;
        case SortKey::Kind::kNumber:
            lua_pushnumber(lua, key.number);
            return;
        case SortKey::Kind::kText:
            lua_pushlstring(lua, key.text, key.length);
            return;
        case SortKey::Kind::kTruth:
            lua_pushboolean(lua, static_cast<int>(key.integer));
            return;
    }
}

/// Pushes a list of the keys of the table at `table`, in order.
void push_sorted_keys(lua_State* lua, int table) {
    std::vector<SortKey> keys;
    for (lua_pushnil(lua); lua_next(lua, table) != 0; lua_pop(lua, 1)) {
        keys.push_back(sort_key_at(lua, -2));
    }
    Interpreter::charge(lua, kPairsUnits + keys.size() * 4);
    std::sort(keys.begin(), keys.end());
    lua_createtable(lua, static_cast<int>(keys.size()), 0);
    for (std::size_t i = 0; i < keys.size(); ++i) {
        push_sort_key(lua, keys[i]);
        lua_rawseti(lua, -2, static_cast<lua_Integer>(i + 1));
    }
}

/// The next entry that is still there. Upvalues: the table, its keys, the number of the last key.
int next_sorted(lua_State* lua) {
    lua_Integer at = lua_tointeger(lua, lua_upvalueindex(3));
    for (;;) {
        ++at;
        if (lua_rawgeti(lua, lua_upvalueindex(2), at) == LUA_TNIL) {
            return 1;
        }
        lua_pushvalue(lua, -1);
        if (lua_rawget(lua, lua_upvalueindex(1)) != LUA_TNIL) {
            lua_pushinteger(lua, at);
            lua_replace(lua, lua_upvalueindex(3));
            return 2;
        }
        lua_pop(lua, 2);
    }
}

/// pairs(t): in order of the keys; entries that are added meanwhile do not come.
int sorted_pairs(lua_State* lua) {
    if (luaL_getmetafield(lua, 1, "__pairs") != LUA_TNIL) {
        lua_pushvalue(lua, 1);
        lua_call(lua, 1, 3);
        return 3;
    }
    luaL_checktype(lua, 1, LUA_TTABLE);
    push_entries(lua, 1);
    push_sorted_keys(lua, lua_gettop(lua));
    lua_pushinteger(lua, 0);
    lua_pushcclosure(lua, next_sorted, 3);
    return 1;
}

/// pcall(f, ...): keeps errors of the script, and no overrun.
int kept_call(lua_State* lua) {
    luaL_checkany(lua, 1);
    const int status = lua_pcall(lua, lua_gettop(lua) - 1, LUA_MULTRET, 0);
    Budget& budget = Interpreter::of(lua).budget();
    if (status == LUA_ERRMEM || budget.overrun != ScriptOverrun::kNone) {
        budget.flag(ScriptOverrun::kMemory);
        Interpreter::raise_overrun(lua);
    }
    budget.reporting = false;
    lua_pushboolean(lua, status == LUA_OK ? 1 : 0);
    lua_insert(lua, 1);
    return lua_gettop(lua);
}

/// error(message [, level])
int raise(lua_State* lua) {
    const lua_Integer level = integer_at_or(lua, 2, 1);
    lua_settop(lua, 1);
    if (lua_type(lua, 1) == LUA_TSTRING && level > 0) {
        luaL_where(lua, static_cast<int>(std::min<lua_Integer>(level, kMostLevels)));
        lua_insert(lua, 1);
        lua_concat(lua, 2);
    }
    return lua_error(lua);
}

/// select(n, ...): the arguments from the n-th on; select('#', ...): how many there are.
int select_from(lua_State* lua) {
    const int count = lua_gettop(lua) - 1;
    if (lua_type(lua, 1) == LUA_TSTRING && std::strcmp(lua_tostring(lua, 1), "#") == 0) {
        lua_pushinteger(lua, count);
        return 1;
    }
    const lua_Integer n = integer_at(lua, 1);
    luaL_argcheck(lua, n != 0 && n >= -count, 1, "there is no such argument");
    return static_cast<int>(n < 0 ? -n : std::max<lua_Integer>(count - n + 1, 0));
}

/// Lua's own function, charged for the texts that it is given.
int counted_call(lua_State* lua) {
    for (int i = 1; i <= lua_gettop(lua); ++i) {
        if (lua_type(lua, i) == LUA_TSTRING) {
            Interpreter::charge(lua, lua_rawlen(lua, i) / kTextBytesPerWork);
        }
    }
    return forward(lua);
}

const char* type_of(lua_State* lua, int index) {
    // Tables of the state are objects of the host, which scripts use like tables.
    return lua_type(lua, index) == LUA_TLIGHTUSERDATA ? "table" : luaL_typename(lua, index);
}

int type_name(lua_State* lua) {
    luaL_checkany(lua, 1);
    lua_pushstring(lua, type_of(lua, 1));
    return 1;
}

int to_readable(lua_State* lua) {
    luaL_checkany(lua, 1);
    push_readable(lua, 1);
    return 1;
}

}  // namespace

void push_readable(lua_State* lua, int index) {
    const int type = lua_type(lua, index);
    if (type == LUA_TTABLE || type == LUA_TFUNCTION || type == LUA_TLIGHTUSERDATA) {
        lua_pushstring(lua, type_of(lua, index));  // never its address
    } else {
        luaL_tolstring(lua, index, nullptr);
    }
}

int forward(lua_State* lua) {
    lua_pushvalue(lua, lua_upvalueindex(1));
    lua_insert(lua, 1);
    lua_call(lua, lua_gettop(lua) - 1, LUA_MULTRET);
    return lua_gettop(lua);
}

void copy_counted(lua_State* lua, int library, const char* name) {
    lua_getfield(lua, library, name);
    lua_pushcclosure(lua, counted_call, 1);
    lua_setfield(lua, -2, name);
}

lua_Integer integer_at(lua_State* lua, int index) {
    luaL_checktype(lua, index, LUA_TNUMBER);
    return luaL_checkinteger(lua, index);
}

lua_Integer integer_at_or(lua_State* lua, int index, lua_Integer otherwise) {
    return lua_isnoneornil(lua, index) ? otherwise : integer_at(lua, index);
}

void open_base(lua_State* lua) {
    luaL_requiref(lua, LUA_GNAME, luaopen_base, 0);
    lua_insert(lua, -2);
    const int library = lua_gettop(lua) - 1;
    for (const char* name : {"assert", "ipairs"}) {
        lua_getfield(lua, library, name);
        lua_setfield(lua, -2, name);
    }
    copy_counted(lua, library, "tonumber");
    lua_remove(lua, library);
    constexpr luaL_Reg kFunctions[] = {{"error", raise},
                                       {"pairs", sorted_pairs},
                                       {"pcall", kept_call},
                                       {"select", select_from},
                                       {"tostring", to_readable},
                                       {"type", type_name},
                                       {nullptr, nullptr}};
    luaL_setfuncs(lua, kFunctions, 0);
}

void open_libraries(lua_State* lua) {
    open_base(lua);
    open_string(lua);
    open_table(lua);
    open_math(lua);
}

}  // namespace zoned::scripting
