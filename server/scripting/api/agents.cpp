#include "server/scripting/api/arguments.h"

#include <optional>

namespace zoned::scripting {

namespace {

// About what these cost, in instructions.
constexpr std::size_t kReadUnits = 20;
constexpr std::size_t kCommandUnits = 200;

/// agent(id): { brain, state, action, target, x, y, z }, the last of its home; nil without one.
int agent(lua_State* lua) {
    const auto reading_of = reading(lua).agent(entity_argument(lua, 1));
    Interpreter::charge(lua, kReadUnits);
    if (!reading_of) {
        lua_pushnil(lua);
        return 1;
    }
    lua_newtable(lua);
    set_text(lua, "brain", reading_of->brain);
    set_text(lua, "state", reading_of->state);
    set_text(lua, "action", reading_of->action);
    push_entity(lua, reading_of->target);
    lua_setfield(lua, -2, "target");
    constexpr const char* kAxes[] = {"x", "y", "z"};
    for (int axis = 0; axis < 3; ++axis) {
        lua_pushnumber(lua, static_cast<lua_Number>(reading_of->home[axis]));
        lua_setfield(lua, -2, kAxes[axis]);
    }
    return 1;
}

/// agent_variable(id, name): nil where there is no such agent or variable.
int agent_variable(lua_State* lua) {
    const std::optional<double> value =
        reading(lua).agent_variable(entity_argument(lua, 1), name_argument(lua, 2, "name"));
    Interpreter::charge(lua, kReadUnits);
    if (value) {
        lua_pushnumber(lua, *value);
    } else {
        lua_pushnil(lua);
    }
    return 1;
}

/// set_agent_variable(id, name, value): false where there is no such agent or variable.
int set_agent_variable(lua_State* lua) {
    zone::RulesContext& context = changing(lua);
    Interpreter::charge(lua, kCommandUnits);
    return push_done(
        lua,
        context.set_agent_variable(
            entity_argument(lua, 1), name_argument(lua, 2, "name"), luaL_checknumber(lua, 3)));
}

/// set_agent_home(id, x, y, z)
int set_agent_home(lua_State* lua) {
    zone::RulesContext& context = changing(lua);
    Interpreter::charge(lua, kCommandUnits);
    const EntityId entity = entity_argument(lua, 1);
    return push_done(lua, context.set_agent_home(entity, position_argument(lua, 2)));
}

}  // namespace

void open_agents(lua_State* lua) {
    constexpr luaL_Reg kFunctions[] = {{"agent", agent},
                                       {"agent_variable", agent_variable},
                                       {"set_agent_variable", set_agent_variable},
                                       {"set_agent_home", set_agent_home},
                                       {nullptr, nullptr}};
    luaL_setfuncs(lua, kFunctions, 0);
}

}  // namespace zoned::scripting
