// script_fields: the fields that a script declares in its table `fields`.
#pragma once

#include "server/scripting/vm/interpreter.h"
#include "server/zone/rules.h"

#include <vector>

namespace zoned::scripting {

/// Of the table of globals at index 1: fields = { { type = "player", name = "score", kind =
/// "number", max = 100 }, ... }. An error of the script where a word, a kind or a value is of
/// another form.
void read_fields(lua_State* lua, std::vector<zone::TypeField>& out);

}  // namespace zoned::scripting
