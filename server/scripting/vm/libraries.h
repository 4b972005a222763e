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

/// Puts Lua's own `name`, of the library at `library`, into the table at the top of the stack. It
/// costs work by the length of the texts that it is given: some are taken for numbers.
void copy_counted(lua_State* lua, int library, const char* name);

/// Calls the function in the first upvalue with the same arguments.
int forward(lua_State* lua);

/// An integer that is no text.
lua_Integer integer_at(lua_State* lua, int index);
/// The same, or `otherwise` where there is none.
lua_Integer integer_at_or(lua_State* lua, int index, lua_Integer otherwise);

/// How a value reads: like tostring, without addresses. Pushes it.
void push_readable(lua_State* lua, int index);

/// The length that a list at an index claims, charged as work.
lua_Integer charged_length(lua_State* lua, int list);

}  // namespace zoned::scripting
