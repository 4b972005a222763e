// PostgresStore: the store in a PostgreSQL database, whose server may be another machine.
#pragma once

#include "server/store/store.h"

#include <cstdint>
#include <memory>
#include <string>

namespace zoned::store {

/// `url` is postgresql://user@host/database?options, as libpq takes it. With `migrate` the tables
/// are made and brought to this program's version; without it nothing is changed. A connection that
/// is lost is opened anew by the next call.
///
/// An answer may be lost too, so that an error may have left its changes there after all. The next
/// commit, if it begins with the same changes, finds that out and does not repeat them.
[[nodiscard]] StoreResult<std::unique_ptr<Store>> open_postgres_store(const std::string& url,
                                                                      bool migrate);

/// The version that this program knows.
[[nodiscard]] std::uint32_t postgres_schema();

/// Tests a migration: an empty database comes to an older version.
StoreResult<bool> migrate_postgres(const std::string& url, std::uint32_t target);

}  // namespace zoned::store
