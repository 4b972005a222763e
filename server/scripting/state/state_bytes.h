// state_bytes: tables of a script's state as bytes, for snapshots and handoffs.
#pragma once

#include "server/scripting/state/state_table.h"

#include <cstdint>
#include <string>
#include <vector>

namespace zoned::core {
class FieldReader;
class FieldWriter;
}  // namespace zoned::core

namespace zoned::scripting {

/// Appends the table with all below it, and what its hash has not seen yet.
void write_table(core::FieldWriter& archive, const StateTable& table);
/// Into an empty table. The bytes may be damaged: then the archive fails.
void read_table(core::FieldReader& archive, StateTable& table);

}  // namespace zoned::scripting
