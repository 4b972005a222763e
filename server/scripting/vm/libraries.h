// libraries: what of Lua's own functions a script has, each safe against what it is given.
#pragma once

#include "server/scripting/vm/interpreter.h"

#include <cstddef>

namespace zoned::scripting {

/// Into the table at the top of the stack: assert, error, ipairs, pairs, pcall, select, tonumber,
/// tostring, type, and the tables string, table and math. Not there: whatever reads files or the
/// clock, loads code, makes coroutines or metatables, or takes patterns.
void open_libraries(lua_State* lua);

void open_base(lua_State* lua);
void open_string(lua_State* lua);
void open_table(lua_State* lua);
void open_math(lua_State* lua);

/// Copies functions of the library at the top of the stack into the table below it.
void copy_functions(lua_State* lua, std::initializer_list<const char*> names);

/// How a value reads: like tostring, without addresses. Pushes it.
void push_readable(lua_State* lua, int index);

/// The length that a list at an index claims, charged as work.
lua_Integer charged_length(lua_State* lua, int list);

}  // namespace zoned::scripting
