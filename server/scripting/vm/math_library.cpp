#include "server/scripting/vm/libraries.h"

namespace zoned::scripting {

void open_math(lua_State* lua) {
    lua_newtable(lua);
    luaL_requiref(lua, LUA_MATHLIBNAME, luaopen_math, 0);
    // Exact on every machine. sin, cos, exp, log and their like differ between C libraries; random
    // is the zone's, of the host.
    copy_functions(lua,
                   {"abs",
                    "ceil",
                    "floor",
                    "fmod",
                    "huge",
                    "max",
                    "maxinteger",
                    "min",
                    "mininteger",
                    "modf",
                    "pi",
                    "sqrt",
                    "tointeger",
                    "type",
                    "ult"});
    lua_setfield(lua, -2, LUA_MATHLIBNAME);
}

}  // namespace zoned::scripting
