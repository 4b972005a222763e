#include "server/store/sqlite_schema.h"

#include <array>
#include <string>

namespace zoned::store {

namespace {

// A step that was released is never changed: files of its version are out there.
constexpr std::array<const char*, 2> kSteps{
    // 0 -> 1
    "CREATE TABLE account (name TEXT PRIMARY KEY, first_login_s INTEGER NOT NULL,"
    " last_login_s INTEGER NOT NULL) WITHOUT ROWID;"
    "CREATE TABLE character (account TEXT NOT NULL, name TEXT NOT NULL,"
    " last_login_s INTEGER NOT NULL, x REAL, y REAL, z REAL, world TEXT,"
    " PRIMARY KEY (account, name)) WITHOUT ROWID;"
    "CREATE TABLE record (scope INTEGER NOT NULL, account TEXT NOT NULL, character TEXT NOT NULL,"
    " key TEXT NOT NULL, value BLOB NOT NULL, PRIMARY KEY (scope, account, character, key));"
    "CREATE TABLE ban (account TEXT PRIMARY KEY, until_s INTEGER NOT NULL, reason TEXT NOT NULL)"
    " WITHOUT ROWID;"
    "CREATE TABLE ticket (nonce BLOB PRIMARY KEY, expires_s INTEGER NOT NULL) WITHOUT ROWID;"
    "CREATE INDEX ticket_expires ON ticket (expires_s);"
    "PRAGMA application_id = 0x7A6F6E64;",
    // 1 -> 2: durable events
    "CREATE TABLE event (number INTEGER PRIMARY KEY AUTOINCREMENT, unix_ms INTEGER NOT NULL,"
    " tick INTEGER NOT NULL, zone INTEGER NOT NULL, kind INTEGER NOT NULL, account TEXT NOT NULL,"
    " topic TEXT NOT NULL, payload BLOB NOT NULL);"
    "CREATE INDEX event_account ON event (account, number) WHERE account <> '';",
};

StoreError foreign(const SqliteDatabase& database) {
    return {StoreFault::kDamaged,
            database.file() + ": it is a SQLite file, but not a store of zoned: move it away"};
}

}  // namespace

std::span<const char* const> sqlite_steps() {
    return kSteps;
}

StoreResult<std::uint32_t> sqlite_schema(SqliteDatabase& database) {
    using Out = StoreResult<std::uint32_t>;
    const auto mark = database.number("PRAGMA application_id");
    if (!mark.ok()) {
        return Out::failure(mark.error());
    }
    const auto version = database.number("PRAGMA user_version");
    const auto tables = database.number("SELECT count(*) FROM sqlite_schema");
    if (!version.ok() || !tables.ok()) {
        return Out::failure(version.ok() ? tables.error() : version.error());
    }
    const bool empty = *mark == 0 && *version == 0 && *tables == 0;
    if (!empty && (*mark != kSqliteMark || *version <= 0)) {
        return Out::failure(foreign(database));
    }
    if (*version > static_cast<std::int64_t>(kSteps.size())) {
        return Out::failure(
            {StoreFault::kNewerSchema,
             database.file() + ": its schema has version " + std::to_string(*version) +
                 ", this server knows up to " + std::to_string(kSteps.size()) +
                 ": run the newer server, or restore a backup from before the upgrade"});
    }
    return static_cast<std::uint32_t>(*version);
}

StoreResult<bool> migrate_sqlite(SqliteDatabase& database, std::size_t target) {
    while (true) {
        // The lock comes first: two servers that start at once must not both take the step.
        auto done = database.run("BEGIN IMMEDIATE");
        if (!done.ok()) {
            return done;
        }
        const auto version = sqlite_schema(database);
        if (!version.ok() || *version >= target) {
            (void)database.run("ROLLBACK");
            return version.ok() ? StoreResult<bool>(true)
                                : StoreResult<bool>::failure(version.error());
        }
        const std::string step = std::string(kSteps[*version]) +
                                 "PRAGMA user_version = " + std::to_string(*version + 1) +
                                 "; COMMIT";
        done = database.run(step.c_str());
        if (!done.ok()) {
            (void)database.run("ROLLBACK");
            return done;
        }
    }
}

}  // namespace zoned::store
