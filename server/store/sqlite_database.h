// SqliteDatabase: one connection to a SQLite file; every call says what went wrong.
#pragma once

#include "server/store/store.h"

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

struct sqlite3;
struct sqlite3_stmt;

namespace zoned::store {

/// A prepared statement. Values are bound from 1 on, in their order; columns count from 0.
class SqliteStatement {
  public:
    SqliteStatement() = default;

    explicit SqliteStatement(sqlite3_stmt* statement) : statement_(statement) {}

    SqliteStatement(SqliteStatement&& other) noexcept;
    SqliteStatement& operator=(SqliteStatement&& other) noexcept;
    ~SqliteStatement();

    /// Forgets the last run and its values.
    void reset();
    void bind(std::int64_t value);
    void bind(double value);
    void bind(std::string_view text);
    void bind(std::span<const std::uint8_t> bytes);

    /// SQLITE_ROW, SQLITE_DONE or an error.
    [[nodiscard]] int step();

    [[nodiscard]] std::int64_t number(int column) const;
    [[nodiscard]] double real(int column) const;
    [[nodiscard]] std::string text(int column) const;
    [[nodiscard]] std::vector<std::uint8_t> bytes(int column) const;

  private:
    sqlite3_stmt* statement_ = nullptr;
    int bound_ = 0;
};

class SqliteDatabase {
  public:
    enum class Access : std::uint8_t {
        kReadOnly,
        kReadWrite,
        kCreate,
    };

    SqliteDatabase() = default;
    SqliteDatabase(const SqliteDatabase&) = delete;
    SqliteDatabase& operator=(const SqliteDatabase&) = delete;
    ~SqliteDatabase();

    StoreResult<bool> open(const std::string& file, Access access);
    void close();

    /// Runs statements that give no rows.
    StoreResult<bool> run(const char* sql);
    StoreResult<SqliteStatement> prepare(const char* sql);
    /// The first column of the first row.
    StoreResult<std::int64_t> number(const char* sql);

    /// The error of the last call.
    [[nodiscard]] StoreError error(int code) const;

    [[nodiscard]] sqlite3* handle() const { return database_; }

    [[nodiscard]] const std::string& file() const { return file_; }

  private:
    sqlite3* database_ = nullptr;
    std::string file_;
};

}  // namespace zoned::store
