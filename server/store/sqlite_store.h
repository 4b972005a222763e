// SqliteStore: the embedded store, a file in WAL mode.
#pragma once

#include "server/store/store.h"

#include <memory>
#include <string>

namespace zoned::store {

enum class Durability : std::uint8_t {
    kProcess,  ///< a commit outlives the process, not a power cut
    kPower,    ///< a commit outlives both
};

enum class StoreUse : std::uint8_t {
    kServe,    ///< makes and migrates the file
    kInspect,  ///< reads a file that is there, and changes nothing in it
};

[[nodiscard]] StoreResult<std::unique_ptr<Store>>
open_sqlite_store(const std::string& file, Durability durability, StoreUse use = StoreUse::kServe);

/// Tests a full disk: the file of this SQLite store gets no larger than that. False for other
/// stores.
bool limit_sqlite_pages(Store& store, std::uint32_t pages);

/// Moves what was committed from the log into the file, beside its writer; on a thread of its own,
/// because it waits for the disk. One connection, opened with the first call.
class SqliteCheckpoint {
  public:
    explicit SqliteCheckpoint(std::string file);
    ~SqliteCheckpoint();

    StoreResult<bool> run();

  private:
    struct Impl;
    std::unique_ptr<Impl> impl_;
};

/// Puts the store of a backup in the place of `file`, which no server may have open. The backup is
/// checked first; what was in `file` is kept beside it, under the name that is returned (empty:
/// there was nothing).
[[nodiscard]] StoreResult<std::string> restore_sqlite(const std::string& backup,
                                                      const std::string& file);

}  // namespace zoned::store
