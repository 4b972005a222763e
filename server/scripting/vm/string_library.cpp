#include "server/scripting/vm/libraries.h"

#include <algorithm>
#include <cctype>
#include <cstring>
#include <string>
#include <string_view>

namespace zoned::scripting {

namespace {

// string.pack's sizes, and widths of string.format.
constexpr std::size_t kMaxFormatBytes = 256;
constexpr long kMaxFormatNumber = 4096;
constexpr lua_Integer kMaxBytesAtOnce = 250;
constexpr std::size_t kStringBytesPerUnit = 16;

std::string_view string_argument(lua_State* lua, int index) {
    std::size_t length = 0;
    const char* text = luaL_checklstring(lua, index, &length);
    return {text, length};
}

void charge_text(lua_State* lua, std::size_t bytes) {
    Interpreter::charge(lua, bytes / kStringBytesPerUnit);
}

/// A format at the first argument whose numbers are small: they are sizes of what is made.
void check_format(lua_State* lua) {
    const std::string_view format = string_argument(lua, 1);
    luaL_argcheck(lua, format.size() <= kMaxFormatBytes, 1, "a format longer than 256 bytes");
    for (std::size_t i = 0; i < format.size(); ++i) {
        long number = 0;
        while (i < format.size() && std::isdigit(static_cast<unsigned char>(format[i])) != 0 &&
               number <= kMaxFormatNumber) {
            number = number * 10 + (format[i++] - '0');
        }
        luaL_argcheck(lua, number <= kMaxFormatNumber, 1, "a size beyond 4096");
    }
}

/// The texts among the arguments from the second on end up in the result.
void check_texts(lua_State* lua) {
    std::size_t bytes = 0;
    for (int i = 2; i <= lua_gettop(lua); ++i) {
        bytes += lua_type(lua, i) == LUA_TSTRING ? string_argument(lua, i).size() : 0;
    }
    luaL_argcheck(lua, bytes <= kMaxTextBytes, 1, "a string longer than 64 KiB");
    charge_text(lua, bytes);
}

int pack_bytes(lua_State* lua) {
    check_format(lua);
    check_texts(lua);
    return forward(lua);
}

int unpack_bytes(lua_State* lua) {
    check_format(lua);
    luaL_checkstack(lua, static_cast<int>(kMaxFormatBytes) + 4, "too many results");
    return forward(lua);
}

bool shows_address(std::string_view format) {
    std::size_t at = format.find('%');
    while (at != std::string_view::npos) {
        at = format.find_first_not_of("-+ #0123456789.", at + 1);
        if (at == std::string_view::npos) {
            return false;
        }
        if (format[at] == 'p') {
            return true;
        }
        at = format.find('%', at + 1);
    }
    return false;
}

/// Like Lua's, without addresses.
int format_text(lua_State* lua) {
    check_format(lua);
    luaL_argcheck(lua,
                  !shows_address(string_argument(lua, 1)),
                  1,
                  "'%p' shows addresses, which differ from run to run");
    for (int i = 2; i <= lua_gettop(lua); ++i) {
        const int type = lua_type(lua, i);
        if (type == LUA_TTABLE || type == LUA_TFUNCTION || type == LUA_TLIGHTUSERDATA) {
            push_readable(lua, i);
            lua_replace(lua, i);
        }
    }
    check_texts(lua);
    return forward(lua);
}

/// rep(s, n [, separator])
int repeat_text(lua_State* lua) {
    const std::string_view text = string_argument(lua, 1);
    const lua_Integer count = integer_at(lua, 2);
    std::size_t length = 0;
    const char* separator = luaL_optlstring(lua, 3, "", &length);
    const std::size_t step = text.size() + length;
    if (count <= 0 || step == 0) {
        lua_pushliteral(lua, "");
        return 1;
    }
    luaL_argcheck(lua,
                  static_cast<std::size_t>(count) <= kMaxTextBytes / step,
                  2,
                  "a string longer than 64 KiB");
    charge_text(lua, step * static_cast<std::size_t>(count));
    std::string out;
    out.reserve(step * static_cast<std::size_t>(count));
    for (lua_Integer i = 0; i < count; ++i) {
        out.append(i == 0 ? "" : separator, i == 0 ? 0 : length).append(text);
    }
    lua_pushlstring(lua, out.data(), out.size());
    return 1;
}

/// The offset that a position of Lua's means: from 1, or from the end where it is negative.
std::size_t offset_of(lua_Integer position, std::size_t length) {
    const auto size = static_cast<lua_Integer>(length);
    if (position < 0) {
        position = std::max<lua_Integer>(size + position + 1, 1);
    }
    return static_cast<std::size_t>(std::clamp<lua_Integer>(position, 1, size + 1) - 1);
}

/// find(s, text [, init]): the text as it is, no pattern. First and last position, or nil.
int find_text(lua_State* lua) {
    const std::string_view text = string_argument(lua, 1);
    const std::string_view wanted = string_argument(lua, 2);
    const std::size_t from = offset_of(integer_at_or(lua, 3, 1), text.size());
    charge_text(lua, text.size() + text.size() * std::min<std::size_t>(wanted.size(), 64));
    const void* const at =
        wanted.size() > text.size() - from
            ? nullptr
            : memmem(text.data() + from, text.size() - from, wanted.data(), wanted.size());
    if (at == nullptr) {
        lua_pushnil(lua);
        return 1;
    }
    const auto first = static_cast<const char*>(at) - text.data();
    lua_pushinteger(lua, first + 1);
    lua_pushinteger(lua, first + static_cast<std::ptrdiff_t>(wanted.size()));
    return 2;
}

/// split(s, separator): a list of the texts between.
int split_text(lua_State* lua) {
    const std::string_view text = string_argument(lua, 1);
    const std::string_view separator = string_argument(lua, 2);
    luaL_argcheck(lua, separator.size() == 1, 2, "one character is wanted");
    lua_newtable(lua);
    std::size_t from = 0;
    for (lua_Integer i = 1; from <= text.size(); ++i) {
        Interpreter::charge(lua, 2);
        const std::size_t end = std::min(text.find(separator[0], from), text.size());
        lua_pushlstring(lua, text.data() + from, end - from);
        lua_rawseti(lua, -2, i);
        from = end + 1;
    }
    charge_text(lua, text.size());
    return 1;
}

/// byte(s [, i [, j]])
int byte_values(lua_State* lua) {
    const std::string_view text = string_argument(lua, 1);
    const lua_Integer first = integer_at_or(lua, 2, 1);
    const lua_Integer last = integer_at_or(lua, 3, first);
    const std::size_t from = offset_of(first, text.size());
    const auto size = static_cast<lua_Integer>(text.size());
    const lua_Integer end = last < 0 ? size + last + 1 : std::min(last, size);
    const lua_Integer count = std::max<lua_Integer>(end - static_cast<lua_Integer>(from), 0);
    luaL_argcheck(lua, count <= kMaxBytesAtOnce, 3, "more than 250 bytes at a time");
    luaL_checkstack(lua, static_cast<int>(count), "too many bytes");
    for (lua_Integer i = 0; i < count; ++i) {
        lua_pushinteger(lua, static_cast<unsigned char>(text[from + static_cast<std::size_t>(i)]));
    }
    return static_cast<int>(count);
}

/// Puts `function`, with Lua's own of that name behind it, into the table at the top. Below it:
/// Lua's library.
void wrap(lua_State* lua, const char* name, lua_CFunction function) {
    lua_getfield(lua, -2, name);
    lua_pushcclosure(lua, function, 1);
    lua_setfield(lua, -2, name);
}

}  // namespace

void open_string(lua_State* lua) {
    luaL_requiref(lua, LUA_STRLIBNAME, luaopen_string, 0);
    lua_newtable(lua);
    lua_getfield(lua, -2, "len");
    lua_setfield(lua, -2, "len");
    for (const char* name : {"char", "lower", "reverse", "sub", "upper"}) {
        copy_counted(lua, lua_gettop(lua) - 1, name);
    }
    wrap(lua, "packsize", unpack_bytes);
    wrap(lua, "pack", pack_bytes);
    wrap(lua, "unpack", unpack_bytes);
    wrap(lua, "format", format_text);
    constexpr luaL_Reg kFunctions[] = {{"rep", repeat_text},
                                       {"find", find_text},
                                       {"split", split_text},
                                       {"byte", byte_values},
                                       {nullptr, nullptr}};
    luaL_setfuncs(lua, kFunctions, 0);
    lua_remove(lua, -2);
    // Methods of texts: s:sub(1, 3). No operators: Lua's own turn texts into numbers.
    lua_pushliteral(lua, "");
    lua_createtable(lua, 0, 1);
    lua_pushvalue(lua, -3);
    lua_setfield(lua, -2, "__index");
    lua_setmetatable(lua, -2);
    lua_pop(lua, 1);
    lua_setfield(lua, -2, LUA_STRLIBNAME);
}

}  // namespace zoned::scripting
