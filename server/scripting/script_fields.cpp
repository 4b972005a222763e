#include "server/scripting/script_fields.h"

#include "server/scripting/vm/freeze.h"

#include <algorithm>
#include <string>
#include <utility>

namespace zoned::scripting {

namespace {

constexpr lua_Integer kMostValues = 1000;

/// The table at the top has this under the name, or else `otherwise`.
double number_of(lua_State* lua, const char* name, double otherwise) {
    const int type = lua_getfield(lua, -1, name);
    const double value = type == LUA_TNIL ? otherwise : lua_tonumber(lua, -1);
    if (type != LUA_TNIL && type != LUA_TNUMBER) {
        luaL_error(lua, "fields: '%s' is no number", name);
    }
    lua_pop(lua, 1);
    return value;
}

std::string text_of(lua_State* lua, const char* name) {
    std::size_t length = 0;
    const int type = lua_getfield(lua, -1, name);
    if (type != LUA_TNIL && type != LUA_TSTRING) {
        luaL_error(lua, "fields: '%s' is no text", name);
    }
    const char* text = type == LUA_TSTRING ? lua_tolstring(lua, -1, &length) : "";
    std::string value(text, length);
    lua_pop(lua, 1);
    return value;
}

bool truth_of(lua_State* lua, const char* name) {
    const int type = lua_getfield(lua, -1, name);
    if (type != LUA_TNIL && type != LUA_TBOOLEAN) {
        luaL_error(lua, "fields: '%s' is neither true nor false", name);
    }
    const bool value = lua_toboolean(lua, -1) != 0;
    lua_pop(lua, 1);
    return value;
}

std::vector<std::string> values_of(lua_State* lua) {
    std::vector<std::string> values;
    const int top = lua_gettop(lua);
    if (lua_getfield(lua, -1, "values") != LUA_TTABLE) {
        luaL_error(lua, "fields: a choice has values = { 'a', 'b' }");
    }
    for (lua_Integer i = 1; i <= kMostValues && lua_geti(lua, -1, i) != LUA_TNIL; ++i) {
        std::size_t length = 0;
        const char* text =
            lua_type(lua, -1) == LUA_TSTRING ? lua_tolstring(lua, -1, &length) : nullptr;
        if (text == nullptr) {
            luaL_error(lua, "fields: a value of a choice is no text");
        }
        values.emplace_back(text, length);
        lua_pop(lua, 1);
    }
    lua_settop(lua, top);
    return values;
}

/// The declaration at the top of the stack.
wire::DeclaredField field_of(lua_State* lua) {
    std::string name = text_of(lua, "name");
    const std::string kind = text_of(lua, "kind");
    if (kind == "number") {
        const double least = number_of(lua, "min", 0.0);
        return wire::number_field(std::move(name),
                                  least,
                                  number_of(lua, "max", 100.0),
                                  number_of(lua, "quantum", 1.0),
                                  number_of(lua, "initial", least));
    }
    if (kind == "choice") {
        std::vector<std::string> values = values_of(lua);
        std::string initial = text_of(lua, "initial");
        if (initial.empty() && !values.empty()) {
            initial = values.front();
        }
        return wire::choice_field(std::move(name), std::move(values), initial);
    }
    if (kind == "flag") {
        return wire::flag_field(std::move(name), truth_of(lua, "initial"));
    }
    if (kind != "text") {
        luaL_error(lua, "fields: a kind is number, choice, flag or text, not '%s'", kind.c_str());
    }
    return wire::text_field(std::move(name), text_of(lua, "initial"));
}

}  // namespace

void read_fields(lua_State* lua, std::vector<zone::TypeField>& out) {
    lua_settop(lua, 1);
    push_entries(lua, 1);
    lua_pushliteral(lua, "fields");
    if (lua_rawget(lua, 2) == LUA_TNIL) {
        return;
    }
    if (!lua_istable(lua, 3)) {
        luaL_error(lua, "fields: a list of tables is wanted");
    }
    constexpr lua_Integer kMostFields = 10'000;
    for (lua_Integer i = 1; i <= kMostFields && lua_geti(lua, 3, i) != LUA_TNIL; ++i) {
        if (!lua_istable(lua, -1)) {
            luaL_error(lua, "fields: a list of tables is wanted");
        }
        zone::TypeField& field = out.emplace_back();
        field.type = text_of(lua, "type");
        field.field = field_of(lua);
        field.max_changes_per_s = number_of(lua, "max_changes_per_s", 0.0);
        lua_settop(lua, 3);
    }
}

}  // namespace zoned::scripting
