#include "server/scripting/loaded_script.h"

#include "server/scripting/script_fields.h"
#include "server/scripting/vm/freeze.h"
#include "server/scripting/vm/libraries.h"

#include <algorithm>
#include <stdexcept>
#include <string>

namespace zoned::scripting {

namespace {

void push_settings(lua_State* lua, const zone::RulesSettings& rules) {
    lua_newtable(lua);
    for (const auto& [name, value] : rules) {
        lua_pushlstring(lua, value.data(), value.size());
        lua_setfield(lua, -2, name.c_str());
    }
}

/// The globals of a script, into a new table at the top of the stack.
void push_globals(lua_State* lua, const zone::RulesSettings& rules) {
    lua_newtable(lua);
    open_libraries(lua);
    open_state(lua);
    open_queries(lua);
    open_places(lua);
    open_actions(lua);
    open_joints(lua);
    open_agents(lua);
    open_parties(lua);
    open_instances(lua);
    open_matches(lua);
    open_events(lua);
    open_store(lua);
    open_messages(lua);
    push_settings(lua, rules);
    lua_setfield(lua, -2, "settings");
}

bool read_flag(lua_State* lua, const char* name) {
    lua_getfield(lua, -1, name);
    const bool on = lua_toboolean(lua, -1) != 0;
    lua_pop(lua, 1);
    return on;
}

}  // namespace

LoadedScript::LoadedScript(const ScriptSettings& settings,
                           const zone::RulesSettings& rules,
                           const world::TypeTable& types,
                           Host& host)
    : interpreter_(settings.limits.memory_bytes, &host),
      wishes_(types.size()) {
    functions_.fill(LUA_NOREF);
    const auto error = interpreter_.run(settings.limits.instructions_per_tick, [&](lua_State* lua) {
        run_file(lua, settings, rules);
        find_callbacks(lua);
        read_wishes(lua, types);
        read_fields(lua, fields_);
    });
    if (error) {
        throw std::runtime_error(error->text);
    }
}

void LoadedScript::run_file(lua_State* lua,
                            const ScriptSettings& settings,
                            const zone::RulesSettings& rules) {
    push_globals(lua, rules);
    const std::string name = "@" + settings.name;
    // "t": bytecode could do anything.
    if (luaL_loadbufferx(lua, settings.source.data(), settings.source.size(), name.c_str(), "t") !=
        LUA_OK) {
        lua_error(lua);
    }
    refuse_powers(lua);
    lua_pushvalue(lua, 1);
    lua_setupvalue(lua, 2, 1);  // its globals
    lua_call(lua, 0, 0);
    freeze_globals(lua);
}

void LoadedScript::find_callbacks(lua_State* lua) {
    push_entries(lua, 1);
    for (lua_pushnil(lua); lua_next(lua, -2) != 0;) {
        std::size_t length = 0;
        const char* text = lua_type(lua, -2) == LUA_TSTRING ? lua_tolstring(lua, -2, &length) : "";
        const std::string_view name(text, length);
        const auto at = std::find(kCallbackNames.begin(), kCallbackNames.end(), name);
        if (at != kCallbackNames.end()) {
            if (!lua_isfunction(lua, -1)) {
                luaL_error(lua, "'%s' is no function", text);
            }
            functions_[static_cast<std::size_t>(at - kCallbackNames.begin())] =
                luaL_ref(lua, LUA_REGISTRYINDEX);
            continue;
        }
        if (name.starts_with("on_") && lua_isfunction(lua, -1)) {
            luaL_error(lua, "there is no callback '%s'", text);
        }
        lua_pop(lua, 1);
    }
}

void LoadedScript::read_wishes(lua_State* lua, const world::TypeTable& types) {
    lua_settop(lua, 1);
    push_entries(lua, 1);
    lua_pushliteral(lua, "contact_wish");
    if (lua_rawget(lua, 2) == LUA_TNIL) {
        return;
    }
    push_entries(lua, 3);
    for (lua_pushnil(lua); lua_next(lua, 4) != 0; lua_pop(lua, 1)) {
        const std::string name = lua_type(lua, -2) == LUA_TSTRING ? lua_tostring(lua, -2) : "";
        const auto at =
            std::find_if(types.begin(), types.end(), [&](const world::EntityType& type) {
                return type.name == name;
            });
        if (at == types.end() || !lua_istable(lua, -1)) {
            luaL_error(
                lua, "contact_wish: tables by names of types are wanted: '%s'", name.c_str());
        }
        wishes_[static_cast<std::size_t>(at - types.begin())] = {read_flag(lua, "lasts"),
                                                                 read_flag(lua, "ends")};
    }
}

}  // namespace zoned::scripting
