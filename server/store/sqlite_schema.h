// SQLite schema: the tables, and the steps from one version to the next.
#pragma once

#include "server/store/sqlite_database.h"

#include <cstdint>
#include <span>

namespace zoned::store {

/// "zond": a file with another mark was made by another program.
inline constexpr std::int64_t kSqliteMark = 0x7A6F6E64;

/// Step n brings a file of version n to version n + 1; a file of version 0 is empty.
[[nodiscard]] std::span<const char* const> sqlite_steps();

/// Brings the file to `target`, each step a transaction. A newer file, and one of another program,
/// is an error and stays as it is.
StoreResult<bool> migrate_sqlite(SqliteDatabase& database,
                                 std::size_t target = sqlite_steps().size());

/// The version of a file of this program, which must not be newer.
StoreResult<std::uint32_t> sqlite_schema(SqliteDatabase& database);

}  // namespace zoned::store
