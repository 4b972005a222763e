#include "server/store/sqlite_store.h"

#include "server/store/sqlite_database.h"
#include "server/store/sqlite_schema.h"

#include <sqlite3.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <utility>

namespace zoned::store {

namespace {

/// Each statement is prepared once; its place here is its place in kSql.
enum Statement : std::size_t {
    kPutRecord,
    kRemoveRecord,
    kForgetRecords,
    kNoteAccount,
    kNoteCharacter,
    kPutStand,
    kPutBan,
    kRemoveBan,
    kUseTicket,
    kForgetTickets,
    kAddEvent,
    kGetRecord,
    kRecords,
    kGetStand,
    kBans,
    kTickets,
    kEvents,
    kEventsOf,
    kStatements,
};

constexpr std::array<const char*, kStatements> kSql{
    "INSERT INTO record (scope, account, character, key, value) VALUES (?1, ?2, ?3, ?4, ?5)"
    " ON CONFLICT DO UPDATE SET value = excluded.value",
    "DELETE FROM record WHERE scope = ?1 AND account = ?2 AND character = ?3 AND key = ?4",
    "DELETE FROM record WHERE scope IN (1, 2) AND account = ?1",
    "INSERT INTO account (name, first_login_s, last_login_s) VALUES (?1, ?2, ?2)"
    " ON CONFLICT DO UPDATE SET last_login_s = excluded.last_login_s",
    "INSERT INTO character (account, name, last_login_s) VALUES (?1, ?2, ?3)"
    " ON CONFLICT DO UPDATE SET last_login_s = excluded.last_login_s",
    "UPDATE character SET x = ?1, y = ?2, z = ?3, world = ?4 WHERE account = ?5 AND name = ?6",
    "INSERT INTO ban (account, until_s, reason) VALUES (?1, ?2, ?3)"
    " ON CONFLICT DO UPDATE SET until_s = excluded.until_s, reason = excluded.reason",
    "DELETE FROM ban WHERE account = ?1",
    "INSERT OR IGNORE INTO ticket (nonce, expires_s) VALUES (?1, ?2)",
    "DELETE FROM ticket WHERE expires_s <= ?1",
    "INSERT INTO event (unix_ms, tick, zone, kind, account, topic, payload)"
    " VALUES (?1, ?2, ?3, ?4, ?5, ?6, ?7)",
    "SELECT value FROM record WHERE scope = ?1 AND account = ?2 AND character = ?3 AND key = ?4",
    "SELECT scope, account, character, key, value FROM record"
    " WHERE scope IN (1, 2) AND account = ?1 ORDER BY scope, character, key",
    "SELECT x, y, z, world FROM character WHERE account = ?1 AND name = ?2 AND world IS NOT NULL",
    "SELECT account, until_s, reason FROM ban ORDER BY account",
    "SELECT nonce, expires_s FROM ticket WHERE expires_s > ?1",
    "SELECT number, unix_ms, tick, zone, kind, account, topic, payload FROM event"
    " ORDER BY number DESC LIMIT ?1",
    "SELECT number, unix_ms, tick, zone, kind, account, topic, payload FROM event"
    " WHERE account = ?1 AND account <> '' ORDER BY number DESC LIMIT ?2",
};

void bind_key(SqliteStatement& statement, const StoreKey& key) {
    statement.bind(static_cast<std::int64_t>(key.scope));
    statement.bind(std::string_view(key.account));
    statement.bind(std::string_view(key.character));
    statement.bind(std::string_view(key.key));
}

class SqliteStore final : public Store {
  public:
    StoreResult<bool> open(const std::string& file, Durability durability, StoreUse use) {
        const auto access = use == StoreUse::kServe ? SqliteDatabase::Access::kCreate
                                                    : SqliteDatabase::Access::kReadWrite;
        auto done = database_.open(file, access);
        if (done.ok() && use == StoreUse::kServe) {
            done = set_up(durability);
        }
        if (done.ok() && use == StoreUse::kInspect) {
            const auto version = sqlite_schema(database_);
            if (!version.ok()) {
                return StoreResult<bool>::failure(version.error());
            }
            if (*version < sqlite_steps().size()) {
                return StoreResult<bool>::failure(
                    {StoreFault::kOther,
                     file + ": its schema has version " + std::to_string(*version) +
                         "; start a server on it once, which brings it to version " +
                         std::to_string(sqlite_steps().size())});
            }
        }
        for (std::size_t i = 0; done.ok() && i < kStatements; ++i) {
            auto prepared = database_.prepare(kSql[i]);
            if (!prepared.ok()) {
                return StoreResult<bool>::failure(prepared.error());
            }
            statements_[i] = std::move(*prepared);
        }
        return done;
    }

    StoreResult<bool> commit(std::span<const StoreChange> changes) override {
        auto begun = database_.run("BEGIN IMMEDIATE");
        if (!begun.ok()) {
            return begun;
        }
        for (const StoreChange& change : changes) {
            const int code = std::visit([this](const auto& c) { return apply(c); }, change);
            if (code != SQLITE_DONE) {
                return rolled_back(database_.error(code));
            }
        }
        auto done = database_.run("COMMIT");
        if (!done.ok()) {
            return rolled_back(done.error());
        }
        return true;
    }

    StoreResult<std::optional<StoredBytes>> get(const StoreKey& key) override {
        SqliteStatement& s = fresh(kGetRecord);
        bind_key(s, key);
        return one<StoredBytes>(s, [&] { return s.bytes(0); });
    }

    StoreResult<std::vector<PutRecord>> records(const std::string& account) override {
        SqliteStatement& s = fresh(kRecords);
        s.bind(std::string_view(account));
        return all<PutRecord>(s, [&] {
            return PutRecord{
                {static_cast<StoreScope>(s.number(0)), s.text(1), s.text(2), s.text(3)},
                s.bytes(4)};
        });
    }

    StoreResult<std::optional<StandingPlace>> stand(const std::string& account,
                                                    const std::string& character) override {
        SqliteStatement& s = fresh(kGetStand);
        s.bind(std::string_view(account));
        s.bind(std::string_view(character));
        return one<StandingPlace>(s, [&] {
            return StandingPlace{{s.real(0), s.real(1), s.real(2)}, s.text(3)};
        });
    }

    StoreResult<std::vector<PutBan>> bans() override {
        SqliteStatement& s = fresh(kBans);
        return all<PutBan>(s, [&] { return PutBan{s.text(0), s.number(1), s.text(2)}; });
    }

    StoreResult<std::vector<UseTicket>> tickets(std::int64_t unix_s) override {
        SqliteStatement& s = fresh(kTickets);
        s.bind(unix_s);
        return all<UseTicket>(s, [&] {
            UseTicket ticket;
            const StoredBytes nonce = s.bytes(0);
            std::copy_n(
                nonce.begin(), std::min(nonce.size(), ticket.nonce.size()), ticket.nonce.begin());
            ticket.expires_s = s.number(1);
            return ticket;
        });
    }

    StoreResult<std::vector<StoredEvent>> events(const std::string& account,
                                                 std::size_t most) override {
        SqliteStatement& s = fresh(account.empty() ? kEvents : kEventsOf);
        if (!account.empty()) {
            s.bind(std::string_view(account));
        }
        s.bind(static_cast<std::int64_t>(most));
        auto found = all<StoredEvent>(s, [&] {
            StoredEvent event;
            event.number = s.number(0);
            event.unix_ms = s.number(1);
            event.tick = s.number(2);
            event.zone = static_cast<std::uint16_t>(s.number(3));
            event.kind = static_cast<std::uint16_t>(s.number(4));
            event.account = s.text(5);
            event.topic = s.text(6);
            event.payload = s.bytes(7);
            return event;
        });
        if (found.ok()) {
            std::reverse(found->begin(), found->end());
        }
        return found;
    }

    StoreResult<StoreCounts> counts() override {
        StoreCounts out;
        const auto version = sqlite_schema(database_);
        if (!version.ok()) {
            return StoreResult<StoreCounts>::failure(version.error());
        }
        out.schema = *version;
        const std::array<std::pair<const char*, std::uint64_t*>, 6> tables{
            {{"SELECT count(*) FROM account", &out.accounts},
             {"SELECT count(*) FROM character", &out.characters},
             {"SELECT count(*) FROM record", &out.records},
             {"SELECT count(*) FROM ban", &out.bans},
             {"SELECT count(*) FROM ticket", &out.tickets},
             {"SELECT count(*) FROM event", &out.events}}};
        for (const auto& [sql, to] : tables) {
            const auto count = database_.number(sql);
            if (!count.ok()) {
                return StoreResult<StoreCounts>::failure(count.error());
            }
            *to = static_cast<std::uint64_t>(*count);
        }
        return out;
    }

    StoreResult<std::vector<std::string>> check() override {
        auto prepared = database_.prepare("PRAGMA integrity_check");
        if (!prepared.ok()) {
            return StoreResult<std::vector<std::string>>::failure(prepared.error());
        }
        SqliteStatement& s = *prepared;
        auto found = all<std::string>(s, [&] { return s.text(0); });
        if (found.ok() && *found == std::vector<std::string>{"ok"}) {
            found->clear();
        }
        return found;
    }

    StoreResult<bool> backup(const std::string& file) override {
        if (std::filesystem::exists(file)) {
            return StoreResult<bool>::failure(
                {StoreFault::kOther, file + ": it is there already; name a new file"});
        }
        SqliteDatabase copy;
        auto done = copy.open(file, SqliteDatabase::Access::kCreate);
        if (!done.ok()) {
            return done;
        }
        sqlite3_backup* backup =
            sqlite3_backup_init(copy.handle(), "main", database_.handle(), "main");
        if (backup == nullptr) {
            return StoreResult<bool>::failure(copy.error(sqlite3_errcode(copy.handle())));
        }
        // In one step: in several, each commit of the server would begin it anew.
        const int stepped = sqlite3_backup_step(backup, -1);
        const int finished = sqlite3_backup_finish(backup);
        if (stepped != SQLITE_DONE || finished != SQLITE_OK) {
            StoreError why = copy.error(stepped != SQLITE_DONE ? stepped : finished);
            copy.close();
            std::error_code ignored;
            std::filesystem::remove(file, ignored);
            return StoreResult<bool>::failure(std::move(why));
        }
        // A backup is one file: the log of a file in WAL mode would be a second one.
        return copy.run("PRAGMA journal_mode = DELETE");
    }

    bool limit_pages(std::uint32_t pages) {
        return database_.run(("PRAGMA max_page_count = " + std::to_string(pages)).c_str()).ok();
    }

  private:
    StoreResult<bool> set_up(Durability durability) {
        // Migration comes before WAL: a file of a newer server stays as it is, to the byte.
        auto done = migrate_sqlite(database_);
        if (done.ok()) {
            done = database_.run("PRAGMA journal_mode = WAL");
        }
        if (done.ok()) {
            // A checkpoint in a commit would wait for the disk twice: SqliteCheckpoint does it.
            done = database_.run("PRAGMA wal_autocheckpoint = 0");
        }
        if (done.ok()) {
            done = database_.run(durability == Durability::kPower ? "PRAGMA synchronous = FULL"
                                                                  : "PRAGMA synchronous = NORMAL");
        }
        return done;
    }

    SqliteStatement& fresh(Statement which) {
        statements_[which].reset();
        return statements_[which];
    }

    int finish(SqliteStatement& statement) {
        const int code = statement.step();
        statement.reset();
        return code;
    }

    StoreResult<bool> rolled_back(StoreError why) {
        if (sqlite3_get_autocommit(database_.handle()) == 0) {
            (void)database_.run("ROLLBACK");
        }
        return StoreResult<bool>::failure(std::move(why));
    }

    template <class T, class Read>
    StoreResult<std::optional<T>> one(SqliteStatement& statement, Read read) {
        const int code = statement.step();
        std::optional<T> out;
        if (code == SQLITE_ROW) {
            out = read();
        } else if (code != SQLITE_DONE) {
            StoreError why = database_.error(code);
            statement.reset();
            return StoreResult<std::optional<T>>::failure(std::move(why));
        }
        statement.reset();
        return out;
    }

    template <class T, class Read>
    StoreResult<std::vector<T>> all(SqliteStatement& statement, Read read) {
        std::vector<T> out;
        int code = statement.step();
        for (; code == SQLITE_ROW; code = statement.step()) {
            out.push_back(read());
        }
        if (code != SQLITE_DONE) {
            StoreError why = database_.error(code);
            statement.reset();
            return StoreResult<std::vector<T>>::failure(std::move(why));
        }
        statement.reset();
        return out;
    }

    int apply(const PutRecord& c) {
        SqliteStatement& s = fresh(kPutRecord);
        bind_key(s, c.key);
        s.bind(std::span<const std::uint8_t>(c.value));
        return finish(s);
    }

    int apply(const RemoveRecord& c) {
        SqliteStatement& s = fresh(kRemoveRecord);
        bind_key(s, c.key);
        return finish(s);
    }

    int apply(const ForgetRecords& c) {
        SqliteStatement& s = fresh(kForgetRecords);
        s.bind(std::string_view(c.account));
        return finish(s);
    }

    int apply(const NoteLogin& c) {
        SqliteStatement& account = fresh(kNoteAccount);
        account.bind(std::string_view(c.account));
        account.bind(c.unix_s);
        if (const int code = finish(account); code != SQLITE_DONE) {
            return code;
        }
        SqliteStatement& character = fresh(kNoteCharacter);
        character.bind(std::string_view(c.account));
        character.bind(std::string_view(c.character));
        character.bind(c.unix_s);
        return finish(character);
    }

    int apply(const PutStand& c) {
        SqliteStatement& s = fresh(kPutStand);
        for (const double coordinate : c.place.position_m) {
            s.bind(coordinate);
        }
        s.bind(std::string_view(c.place.world));
        s.bind(std::string_view(c.account));
        s.bind(std::string_view(c.character));
        return finish(s);
    }

    int apply(const PutBan& c) {
        SqliteStatement& s = fresh(kPutBan);
        s.bind(std::string_view(c.account));
        s.bind(c.until_unix_s);
        s.bind(std::string_view(c.reason));
        return finish(s);
    }

    int apply(const RemoveBan& c) {
        SqliteStatement& s = fresh(kRemoveBan);
        s.bind(std::string_view(c.account));
        return finish(s);
    }

    int apply(const UseTicket& c) {
        SqliteStatement& s = fresh(kUseTicket);
        s.bind(std::span<const std::uint8_t>(c.nonce));
        s.bind(c.expires_s);
        return finish(s);
    }

    int apply(const ForgetTickets& c) {
        SqliteStatement& s = fresh(kForgetTickets);
        s.bind(c.expired_at_s);
        return finish(s);
    }

    int apply(const AddEvent& c) {
        SqliteStatement& s = fresh(kAddEvent);
        s.bind(c.unix_ms);
        s.bind(static_cast<std::int64_t>(c.tick));
        s.bind(static_cast<std::int64_t>(c.zone));
        s.bind(static_cast<std::int64_t>(c.kind));
        s.bind(std::string_view(c.account));
        s.bind(std::string_view(c.topic));
        s.bind(std::span<const std::uint8_t>(c.payload));
        return finish(s);
    }

    SqliteDatabase database_;  // outlives its statements
    std::array<SqliteStatement, kStatements> statements_;
};

}  // namespace

StoreResult<std::unique_ptr<Store>> open_sqlite_store(const std::string& file,
                                                      Durability durability,
                                                      StoreUse use) {
    auto store = std::make_unique<SqliteStore>();
    const auto done = store->open(file, durability, use);
    if (!done.ok()) {
        return StoreResult<std::unique_ptr<Store>>::failure(done.error());
    }
    return StoreResult<std::unique_ptr<Store>>(std::move(store));
}

bool limit_sqlite_pages(Store& store, std::uint32_t pages) {
    auto* sqlite = dynamic_cast<SqliteStore*>(&store);
    return sqlite != nullptr && sqlite->limit_pages(pages);
}

struct SqliteCheckpoint::Impl {
    std::string file;
    SqliteDatabase database;
};

SqliteCheckpoint::SqliteCheckpoint(std::string file) : impl_(std::make_unique<Impl>()) {
    impl_->file = std::move(file);
}

SqliteCheckpoint::~SqliteCheckpoint() = default;

StoreResult<bool> SqliteCheckpoint::run() {
    if (impl_->database.handle() == nullptr) {
        auto done = impl_->database.open(impl_->file, SqliteDatabase::Access::kReadWrite);
        if (!done.ok()) {
            return done;
        }
        // A connection that has read nothing does not know yet that the file has a log, and would
        // find nothing to do.
        const auto read = impl_->database.number("SELECT count(*) FROM sqlite_schema");
        if (!read.ok()) {
            impl_->database.close();
            return StoreResult<bool>::failure(read.error());
        }
    }
    const int code = sqlite3_wal_checkpoint_v2(
        impl_->database.handle(), nullptr, SQLITE_CHECKPOINT_PASSIVE, nullptr, nullptr);
    return code == SQLITE_OK ? StoreResult<bool>(true)
                             : StoreResult<bool>::failure(impl_->database.error(code));
}

StoreResult<std::string> restore_sqlite(const std::string& backup, const std::string& file) {
    using Out = StoreResult<std::string>;
    const auto fail = [](std::string text) {
        return Out::failure({StoreFault::kOther, std::move(text)});
    };
    const std::string fresh = file + ".restored";
    std::error_code ignored;
    {
        SqliteDatabase from;
        auto opened = from.open(backup, SqliteDatabase::Access::kReadOnly);
        if (!opened.ok()) {
            return Out::failure(opened.error());
        }
        const auto version = sqlite_schema(from);
        if (!version.ok() || *version == 0) {
            return version.ok() ? fail(backup + ": it is empty, and no backup")
                                : Out::failure(version.error());
        }
    }
    std::error_code error;
    std::filesystem::copy_file(
        backup, fresh, std::filesystem::copy_options::overwrite_existing, error);
    if (error) {
        return fail(fresh + ": cannot be written: " + error.message());
    }
    {
        // The copy is opened as a server would: it is checked and migrated before it counts.
        auto store = open_sqlite_store(fresh, Durability::kPower);
        const auto wrong = store.ok()
                               ? (*store)->check()
                               : StoreResult<std::vector<std::string>>::failure(store.error());
        if (!wrong.ok() || !wrong->empty()) {
            StoreError why = wrong.ok() ? StoreError{StoreFault::kDamaged,
                                                     backup + ": it is damaged: " + wrong->front()}
                                        : wrong.error();
            store = StoreResult<std::unique_ptr<Store>>::failure({});
            for (const char* ending : {"", "-wal", "-shm"}) {
                std::filesystem::remove(fresh + ending, ignored);
            }
            return Out::failure(std::move(why));
        }
    }
    std::string kept;
    if (std::filesystem::exists(file)) {
        SqliteDatabase old;
        auto held = old.open(file, SqliteDatabase::Access::kReadWrite);
        if (held.ok()) {
            // Only where nobody else has it open does this move the log into the file.
            held = old.run("PRAGMA locking_mode = EXCLUSIVE; BEGIN EXCLUSIVE; COMMIT");
        }
        if (!held.ok() && held.error().fault == StoreFault::kBusy) {
            return fail(file + ": a server has it open: stop it first");
        }
        for (int n = 1; kept.empty() || std::filesystem::exists(kept); ++n) {
            kept = file + ".before-" + std::to_string(n);
        }
    }
    if (!kept.empty()) {
        for (const char* ending : {"", "-wal", "-shm"}) {
            std::filesystem::rename(file + ending, kept + ending, ending[0] == 0 ? error : ignored);
        }
    }
    if (!error) {
        std::filesystem::rename(fresh, file, error);
    }
    return error ? fail(file + ": cannot be replaced: " + error.message()) : Out(kept);
}

}  // namespace zoned::store
