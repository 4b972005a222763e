// freeze: after a script's file has run, nothing of it can be written to any more.
#pragma once

#include "server/scripting/vm/interpreter.h"

namespace zoned::scripting {

/// Makes the table at the top of the stack (the globals), all tables and functions that can be
/// reached from it, and the library of texts read-only. An error where a kept function writes to
/// locals that outlive a call.
void freeze_globals(lua_State* lua);

/// An error where a compiled function, at the top of the stack, raises to a power.
void refuse_powers(lua_State* lua);

/// Pushes the table with a table's own entries: the one that a read-only table stands for, or the
/// table itself.
void push_entries(lua_State* lua, int table);

/// Whether the table at an index is read-only.
bool is_frozen(lua_State* lua, int table);

}  // namespace zoned::scripting
