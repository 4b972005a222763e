#include "server/store/sqlite_database.h"

#include <fcntl.h>
#include <sqlite3.h>
#include <unistd.h>

#include <utility>

namespace zoned::store {

namespace {

/// Another process, a backup say, may hold the file this long before it is an error.
constexpr int kBusyMs = 2000;

StoreFault fault_of(int code) {
    switch (code & 0xFF) {
        case SQLITE_BUSY:
        case SQLITE_LOCKED:
            return StoreFault::kBusy;
        case SQLITE_FULL:
            return StoreFault::kFull;
        case SQLITE_CORRUPT:
        case SQLITE_NOTADB:
            return StoreFault::kDamaged;
        default:
            return StoreFault::kOther;
    }
}

const char* advice_for(StoreFault fault) {
    switch (fault) {
        case StoreFault::kBusy:
            return ": another process holds it";
        case StoreFault::kFull:
            return ": make room on the disk";
        case StoreFault::kDamaged:
            return ": restore a backup (zoned restore), or move the file away to start anew";
        default:
            return "";
    }
}

}  // namespace

SqliteStatement::SqliteStatement(SqliteStatement&& other) noexcept
    : statement_(std::exchange(other.statement_, nullptr)),
      bound_(other.bound_) {
}

SqliteStatement& SqliteStatement::operator=(SqliteStatement&& other) noexcept {
    std::swap(statement_, other.statement_);
    std::swap(bound_, other.bound_);
    return *this;
}

SqliteStatement::~SqliteStatement() {
    sqlite3_finalize(statement_);
}

void SqliteStatement::reset() {
    sqlite3_reset(statement_);
    sqlite3_clear_bindings(statement_);
    bound_ = 0;
}

void SqliteStatement::bind(std::int64_t value) {
    sqlite3_bind_int64(statement_, ++bound_, value);
}

void SqliteStatement::bind(double value) {
    sqlite3_bind_double(statement_, ++bound_, value);
}

void SqliteStatement::bind(std::string_view text) {
    // A null pointer would bind NULL: an empty view may have one.
    sqlite3_bind_text(statement_,
                      ++bound_,
                      text.empty() ? "" : text.data(),
                      static_cast<int>(text.size()),
                      SQLITE_TRANSIENT);
}

void SqliteStatement::bind(std::span<const std::uint8_t> bytes) {
    if (bytes.empty()) {
        sqlite3_bind_zeroblob(statement_, ++bound_, 0);
        return;
    }
    sqlite3_bind_blob(
        statement_, ++bound_, bytes.data(), static_cast<int>(bytes.size()), SQLITE_TRANSIENT);
}

int SqliteStatement::step() {
    return sqlite3_step(statement_);
}

std::int64_t SqliteStatement::number(int column) const {
    return sqlite3_column_int64(statement_, column);
}

double SqliteStatement::real(int column) const {
    return sqlite3_column_double(statement_, column);
}

std::string SqliteStatement::text(int column) const {
    const unsigned char* text = sqlite3_column_text(statement_, column);
    const int size = sqlite3_column_bytes(statement_, column);
    return text == nullptr
               ? std::string()
               : std::string(reinterpret_cast<const char*>(text), static_cast<std::size_t>(size));
}

std::vector<std::uint8_t> SqliteStatement::bytes(int column) const {
    const auto* data = static_cast<const std::uint8_t*>(sqlite3_column_blob(statement_, column));
    const int size = sqlite3_column_bytes(statement_, column);
    return data == nullptr ? std::vector<std::uint8_t>()
                           : std::vector<std::uint8_t>(data, data + size);
}

SqliteDatabase::~SqliteDatabase() {
    close();
}

StoreResult<bool> SqliteDatabase::open(const std::string& file, Access access) {
    file_ = file;
    if (access == Access::kCreate) {
        // The list of players and bans is nobody else's business. SQLite gives its other
        // files the mode of this one. Where it cannot be made, SQLite says so.
        const int made = ::open(file.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0600);
        if (made >= 0) {
            ::close(made);
        }
    }
    const int flags = access == Access::kReadOnly    ? SQLITE_OPEN_READONLY
                      : access == Access::kReadWrite ? SQLITE_OPEN_READWRITE
                                                     : SQLITE_OPEN_READWRITE | SQLITE_OPEN_CREATE;
    const int code =
        sqlite3_open_v2(file.c_str(), &database_, flags | SQLITE_OPEN_NOMUTEX, nullptr);
    if (code != SQLITE_OK) {
        StoreError why = error(code);
        close();
        return StoreResult<bool>::failure(std::move(why));
    }
    sqlite3_busy_timeout(database_, kBusyMs);
    // A file from outside must not run what somebody wrote into its schema.
    sqlite3_db_config(database_, SQLITE_DBCONFIG_DEFENSIVE, 1, nullptr);
    sqlite3_db_config(database_, SQLITE_DBCONFIG_TRUSTED_SCHEMA, 0, nullptr);
    sqlite3_db_config(database_, SQLITE_DBCONFIG_ENABLE_TRIGGER, 0, nullptr);
    return true;
}

void SqliteDatabase::close() {
    sqlite3_close_v2(std::exchange(database_, nullptr));
}

StoreResult<bool> SqliteDatabase::run(const char* sql) {
    const int code = sqlite3_exec(database_, sql, nullptr, nullptr, nullptr);
    return code == SQLITE_OK ? StoreResult<bool>(true) : StoreResult<bool>::failure(error(code));
}

StoreResult<SqliteStatement> SqliteDatabase::prepare(const char* sql) {
    sqlite3_stmt* statement = nullptr;
    const int code = sqlite3_prepare_v2(database_, sql, -1, &statement, nullptr);
    if (code != SQLITE_OK) {
        return StoreResult<SqliteStatement>::failure(error(code));
    }
    return SqliteStatement(statement);
}

StoreResult<std::int64_t> SqliteDatabase::number(const char* sql) {
    auto statement = prepare(sql);
    if (!statement.ok()) {
        return StoreResult<std::int64_t>::failure(statement.error());
    }
    const int code = statement->step();
    if (code != SQLITE_ROW) {
        return StoreResult<std::int64_t>::failure(error(code));
    }
    return statement->number(0);
}

StoreError SqliteDatabase::error(int code) const {
    const StoreFault fault = fault_of(code);
    const char* what = database_ != nullptr ? sqlite3_errmsg(database_) : sqlite3_errstr(code);
    return {fault, file_ + ": " + what + advice_for(fault)};
}

}  // namespace zoned::store
