#include "server/scripting/vm/libraries.h"

#include <algorithm>
#include <string>
#include <utility>

namespace zoned::scripting {

namespace {

constexpr lua_Integer kMaxListLength = 1'000'000;
constexpr lua_Integer kMaxValuesAtOnce = 250;
constexpr int kUnitsPerMove = 4;

void check_list(lua_State* lua, int index) {
    const int type = lua_type(lua, index);
    if (type != LUA_TTABLE && type != LUA_TLIGHTUSERDATA) {
        luaL_typeerror(lua, index, "table");
    }
}

/// insert(list, [at,] value)
int insert_entry(lua_State* lua) {
    check_list(lua, 1);
    const lua_Integer end = luaL_len(lua, 1) + 1;
    lua_Integer at = end;
    if (lua_gettop(lua) == 3) {
        at = integer_at(lua, 2);
        luaL_argcheck(lua, at >= 1 && at <= end, 2, "a place within the list is wanted");
    } else if (lua_gettop(lua) != 2) {
        return luaL_error(lua, "insert: a list, perhaps a place, and a value are wanted");
    }
    Interpreter::charge(lua, static_cast<std::size_t>((end - at) * kUnitsPerMove));
    for (lua_Integer i = end; i > at; --i) {
        lua_geti(lua, 1, i - 1);
        lua_seti(lua, 1, i);
    }
    lua_settop(lua, lua_gettop(lua) == 3 ? 3 : 2);
    lua_seti(lua, 1, at);
    return 0;
}

/// remove(list [, at]): the value that was there.
int remove_entry(lua_State* lua) {
    check_list(lua, 1);
    const lua_Integer length = luaL_len(lua, 1);
    if (length == 0) {
        lua_pushnil(lua);
        return 1;
    }
    const lua_Integer at = integer_at_or(lua, 2, length);
    luaL_argcheck(lua, at >= 1 && at <= length, 2, "a place within the list is wanted");
    Interpreter::charge(lua, static_cast<std::size_t>((length - at) * kUnitsPerMove));
    lua_geti(lua, 1, at);
    for (lua_Integer i = at; i < length; ++i) {
        lua_geti(lua, 1, i + 1);
        lua_seti(lua, 1, i);
    }
    lua_pushnil(lua);
    lua_seti(lua, 1, length);
    return 1;
}

/// concat(list [, separator])
int concat_entries(lua_State* lua) {
    check_list(lua, 1);
    std::size_t length = 0;
    const char* separator = luaL_optlstring(lua, 2, "", &length);
    const lua_Integer count = charged_length(lua, 1);
    std::string out;
    for (lua_Integer i = 1; i <= count; ++i) {
        lua_geti(lua, 1, i);
        std::size_t size = 0;
        const char* text = lua_tolstring(lua, -1, &size);
        if (text == nullptr) {
            return luaL_error(lua,
                              "concat: entry %I is a %s, a string or number is wanted",
                              static_cast<LUAI_UACINT>(i),
                              luaL_typename(lua, -1));
        }
        out.append(i == 1 ? "" : separator, i == 1 ? 0 : length).append(text, size);
        if (out.size() > kMaxTextBytes) {
            return luaL_error(lua, "concat: a string longer than 64 KiB");
        }
        lua_pop(lua, 1);
    }
    lua_pushlstring(lua, out.data(), out.size());
    return 1;
}

/// unpack(list [, first [, last]])
int unpack_entries(lua_State* lua) {
    check_list(lua, 1);
    const lua_Integer first = integer_at_or(lua, 2, 1);
    const lua_Integer last = integer_at_or(lua, 3, luaL_len(lua, 1));
    if (last < first) {
        return 0;
    }
    luaL_argcheck(lua,
                  static_cast<lua_Unsigned>(last) - static_cast<lua_Unsigned>(first) <
                      static_cast<lua_Unsigned>(kMaxValuesAtOnce),
                  1,
                  "more than 250 values at a time");
    const int count = static_cast<int>(last - first + 1);
    luaL_checkstack(lua, count, "too many values");
    for (lua_Integer i = first; i <= last; ++i) {
        lua_geti(lua, 1, i);
    }
    return count;
}

/// Whether the value at index b goes before the one at index a.
bool goes_before(lua_State* lua, int b, int a) {
    if (lua_isnoneornil(lua, 2)) {
        return lua_compare(lua, b, a, LUA_OPLT) != 0;
    }
    lua_pushvalue(lua, 2);
    lua_pushvalue(lua, b < 0 ? b - 1 : b);
    lua_pushvalue(lua, a < 0 ? a - 2 : a);
    lua_call(lua, 2, 1);
    const bool before = lua_toboolean(lua, -1) != 0;
    lua_pop(lua, 1);
    return before;
}

/// Merges the sorted runs [from, middle) and [middle, end) of `source` into `target`.
void merge_runs(lua_State* lua,
                int source,
                int target,
                lua_Integer from,
                lua_Integer middle,
                lua_Integer end) {
    lua_Integer left = from;
    lua_Integer right = middle;
    for (lua_Integer to = from; to < end; ++to) {
        bool take_right = left == middle;
        if (!take_right && right < end) {
            lua_rawgeti(lua, source, left);
            lua_rawgeti(lua, source, right);
            take_right = goes_before(lua, -1, -2);
            lua_pop(lua, 2);
        }
        lua_rawgeti(lua, source, take_right ? right++ : left++);
        lua_rawseti(lua, target, to);
    }
}

/// sort(list [, before]): stable, and the same on every run whatever `before` says. Lua's own
/// takes its pivots from a clock.
int sort_entries(lua_State* lua) {
    check_list(lua, 1);
    lua_settop(lua, 2);
    const lua_Integer count = charged_length(lua, 1);
    lua_createtable(lua, static_cast<int>(count), 0);
    lua_createtable(lua, static_cast<int>(count), 0);
    int source = 3;
    int target = 4;
    for (lua_Integer i = 1; i <= count; ++i) {
        lua_geti(lua, 1, i);
        lua_rawseti(lua, source, i);
    }
    for (lua_Integer run = 1; run < count; run *= 2) {
        Interpreter::charge(lua, static_cast<std::size_t>(count * kUnitsPerMove));
        for (lua_Integer from = 1; from <= count; from += 2 * run) {
            const lua_Integer middle = std::min(from + run, count + 1);
            merge_runs(lua, source, target, from, middle, std::min(from + 2 * run, count + 1));
        }
        std::swap(source, target);
    }
    for (lua_Integer i = 1; i <= count; ++i) {
        lua_rawgeti(lua, source, i);
        lua_seti(lua, 1, i);
    }
    return 0;
}

}  // namespace

lua_Integer charged_length(lua_State* lua, int list) {
    const lua_Integer length = luaL_len(lua, list);
    if (length > kMaxListLength) {
        luaL_error(lua, "a list of more than a million entries");
    }
    Interpreter::charge(lua, static_cast<std::size_t>(length * kUnitsPerMove));
    return length;
}

void open_table(lua_State* lua) {
    constexpr luaL_Reg kFunctions[] = {{"insert", insert_entry},
                                       {"remove", remove_entry},
                                       {"concat", concat_entries},
                                       {"unpack", unpack_entries},
                                       {"sort", sort_entries},
                                       {nullptr, nullptr}};
    luaL_newlib(lua, kFunctions);
    lua_setfield(lua, -2, LUA_TABLIBNAME);
}

}  // namespace zoned::scripting
