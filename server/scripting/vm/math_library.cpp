#include "server/scripting/vm/libraries.h"

namespace zoned::scripting {

void open_math(lua_State* lua) {
    luaL_requiref(lua, LUA_MATHLIBNAME, luaopen_math, 0);
    lua_newtable(lua);
    const int library = lua_gettop(lua) - 1;
    for (const char* name : {"huge", "maxinteger", "mininteger", "pi"}) {
        lua_getfield(lua, library, name);
        lua_setfield(lua, -2, name);
    }
    // Exact on every machine. sin, cos, exp, log and their like differ between C libraries; random
    // is the zone's, of the host.
    for (const char* name : {"abs",
                             "ceil",
                             "floor",
                             "fmod",
                             "max",
                             "min",
                             "modf",
                             "sqrt",
                             "tointeger",
                             "type",
                             "ult"}) {
        copy_counted(lua, library, name);
    }
    lua_remove(lua, library);
    lua_setfield(lua, -2, LUA_MATHLIBNAME);
}

}  // namespace zoned::scripting
