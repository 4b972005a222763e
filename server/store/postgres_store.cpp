#include "server/store/postgres_store.h"

#include "shared/core/utf8.h"

#include <pqxx/pqxx>

#include <algorithm>
#include <array>
#include <utility>

namespace zoned::store {

namespace {

// A step that was released is never changed: databases of its version are out there.
constexpr std::array<const char*, 2> kPostgresSteps{
    // 0 -> 1
    "CREATE TABLE account (name TEXT PRIMARY KEY, first_login_s BIGINT NOT NULL,"
    " last_login_s BIGINT NOT NULL);"
    "CREATE TABLE character (account TEXT NOT NULL, name TEXT NOT NULL,"
    " last_login_s BIGINT NOT NULL, x DOUBLE PRECISION, y DOUBLE PRECISION, z DOUBLE PRECISION,"
    " world TEXT, PRIMARY KEY (account, name));"
    "CREATE TABLE record (scope SMALLINT NOT NULL, account TEXT NOT NULL, character TEXT NOT NULL,"
    " key TEXT NOT NULL, value BYTEA NOT NULL, PRIMARY KEY (scope, account, character, key));"
    "CREATE TABLE ban (account TEXT PRIMARY KEY, until_s BIGINT NOT NULL, reason TEXT NOT NULL);"
    "CREATE TABLE ticket (nonce BYTEA PRIMARY KEY, expires_s BIGINT NOT NULL);"
    "CREATE INDEX ticket_expires ON ticket (expires_s);",
    // 1 -> 2: durable events
    "CREATE TABLE event (number BIGSERIAL PRIMARY KEY, unix_ms BIGINT NOT NULL,"
    " tick BIGINT NOT NULL, zone INTEGER NOT NULL, kind INTEGER NOT NULL, account TEXT NOT NULL,"
    " topic TEXT NOT NULL, payload BYTEA NOT NULL);"
    "CREATE INDEX event_account ON event (account, number) WHERE account <> '';",
};

constexpr std::array<std::pair<const char*, const char*>, 18> kPrepared{{
    {"put_record",
     "INSERT INTO record VALUES ($1, $2, $3, $4, $5) ON CONFLICT (scope, account, character, key)"
     " DO UPDATE SET value = excluded.value"},
    {"remove_record",
     "DELETE FROM record WHERE scope = $1 AND account = $2 AND character = $3 AND key = $4"},
    {"forget_records", "DELETE FROM record WHERE scope IN (1, 2) AND account = $1"},
    {"note_account",
     "INSERT INTO account VALUES ($1, $2, $2) ON CONFLICT (name)"
     " DO UPDATE SET last_login_s = excluded.last_login_s"},
    {"note_character",
     "INSERT INTO character (account, name, last_login_s) VALUES ($1, $2, $3)"
     " ON CONFLICT (account, name) DO UPDATE SET last_login_s = excluded.last_login_s"},
    {"put_stand",
     "UPDATE character SET x = $1, y = $2, z = $3, world = $4 WHERE account = $5 AND name = $6"},
    {"put_ban",
     "INSERT INTO ban VALUES ($1, $2, $3) ON CONFLICT (account)"
     " DO UPDATE SET until_s = excluded.until_s, reason = excluded.reason"},
    {"remove_ban", "DELETE FROM ban WHERE account = $1"},
    {"use_ticket", "INSERT INTO ticket VALUES ($1, $2) ON CONFLICT DO NOTHING"},
    {"forget_tickets", "DELETE FROM ticket WHERE expires_s <= $1"},
    {"add_event",
     "INSERT INTO event (unix_ms, tick, zone, kind, account, topic, payload)"
     " VALUES ($1, $2, $3, $4, $5, $6, $7)"},
    {"get_record",
     "SELECT value FROM record"
     " WHERE scope = $1 AND account = $2 AND character = $3 AND key = $4"},
    {"records",
     "SELECT scope, account, character, key, value FROM record"
     " WHERE scope IN (1, 2) AND account = $1"
     " ORDER BY scope, character COLLATE \"C\", key COLLATE \"C\""},
    {"get_stand",
     "SELECT x, y, z, world FROM character"
     " WHERE account = $1 AND name = $2 AND world IS NOT NULL"},
    {"bans", "SELECT account, until_s, reason FROM ban ORDER BY account COLLATE \"C\""},
    {"tickets", "SELECT nonce, expires_s FROM ticket WHERE expires_s > $1"},
    {"events",
     "SELECT number, unix_ms, tick, zone, kind, account, topic, payload FROM event"
     " ORDER BY number DESC LIMIT $1"},
    {"events_of",
     "SELECT number, unix_ms, tick, zone, kind, account, topic, payload FROM event"
     " WHERE account = $1 AND account <> '' ORDER BY number DESC LIMIT $2"},
}};

/// So that two servers that start at once do not both migrate ("zond").
constexpr const char* kLock = "SELECT pg_advisory_xact_lock(1517252196)";

/// Settings of a session, so that a server keeps its promises. A backend whose client is gone lets
/// go of its rows after 10 s; nobody waits longer than 2 s for a lock.
constexpr const char* kSession =
    "SET client_encoding = 'UTF8';"
    "SET client_min_messages = 'error';"
    "SET lock_timeout = '2s';"
    "SET idle_in_transaction_session_timeout = '10s';"
    "SELECT set_config('synchronous_commit', 'on', false)"
    " WHERE current_setting('synchronous_commit') = 'off'";

/// Adds what the URL leaves open, so that a machine that is gone is noticed within 10 s.
std::string with_patience(std::string url) {
    for (const std::string_view option : {"connect_timeout=5",
                                          "tcp_user_timeout=10000",
                                          "keepalives_idle=5",
                                          "keepalives_interval=2",
                                          "keepalives_count=3",
                                          "fallback_application_name=zoned"}) {
        if (url.find(option.substr(0, option.find('=') + 1)) == std::string::npos) {
            url += url.find('?') == std::string::npos ? '?' : '&';
            url += option;
        }
    }
    return url;
}

pqxx::binarystring binary(std::span<const std::uint8_t> bytes) {
    // A null pointer would be NULL: an empty span may have one.
    return {bytes.empty() ? static_cast<const void*>("") : bytes.data(), bytes.size()};
}

/// Text as PostgreSQL takes it. Bytes that are no UTF-8, and zeros, become '?': a commit that is
/// refused for ever would keep all later ones waiting.
std::string text(const std::string& from) {
    if (core::is_clean_utf8(from)) {
        return from;
    }
    std::string out;
    for (std::size_t at = 0; at < from.size();) {
        std::uint32_t code = 0;
        const std::size_t bytes = core::decode_utf8(std::string_view(from).substr(at), code);
        if (bytes == 0 || code == 0) {
            out += '?';
            ++at;
        } else {
            out.append(from, at, bytes);
            at += bytes;
        }
    }
    return out;
}

StoredBytes bytes_of(const pqxx::field& field) {
    const pqxx::binarystring raw(field);
    return {raw.data(), raw.data() + raw.size()};
}

/// Messages of libpq are of several lines.
std::string one_line(std::string text) {
    std::replace(text.begin(), text.end(), '\n', ' ');
    text.erase(text.find_last_not_of(' ') + 1);
    return text;
}

StoreError lost(const std::exception& error) {
    return {StoreFault::kLost,
            "PostgreSQL: no connection: " + one_line(error.what()) +
                " (store.url, and whether its server runs)"};
}

/// The server has not seen yet that the line is gone.
struct StillUnderWay {};

StoreFault fault_of_state(const std::string& state) {
    // 53100: the disk is full; 57P: the server ends; 40: a conflict; 55P03: a lock.
    if (state == "53100") {
        return StoreFault::kFull;
    }
    if (state.starts_with("57P") || state.starts_with("08")) {
        return StoreFault::kLost;
    }
    return state.starts_with("40") || state == "55P03" ? StoreFault::kBusy : StoreFault::kOther;
}

/// Runs `work`; what it throws becomes an error.
template <class T, class Work>
StoreResult<T> guarded(Work work) {
    try {
        return work();
    } catch (const pqxx::broken_connection& error) {
        return StoreResult<T>::failure(lost(error));
    } catch (const pqxx::sql_error& error) {
        return StoreResult<T>::failure(
            {fault_of_state(error.sqlstate()), "PostgreSQL: " + one_line(error.what())});
    } catch (const StillUnderWay&) {
        return StoreResult<T>::failure(
            {StoreFault::kBusy, "PostgreSQL: a commit whose answer was lost is still under way"});
    } catch (const pqxx::in_doubt_error& error) {
        return StoreResult<T>::failure(lost(error));
    } catch (const std::exception& error) {
        return StoreResult<T>::failure(
            {StoreFault::kOther, "PostgreSQL: " + one_line(error.what())});
    }
}

std::uint32_t version_of(pqxx::transaction_base& work) {
    const bool made = work.exec1("SELECT to_regclass('zoned_schema') IS NOT NULL")[0].as<bool>();
    return made ? work.exec1("SELECT max(version) FROM zoned_schema")[0].as<std::uint32_t>() : 0U;
}

StoreError newer(std::uint32_t version) {
    return {StoreFault::kNewerSchema,
            "PostgreSQL: the schema of the database has version " + std::to_string(version) +
                ", this server knows up to " + std::to_string(kPostgresSteps.size()) +
                ": run the newer server, or restore a dump from before the upgrade"};
}

StoreResult<bool> migrate(pqxx::connection& connection, std::uint32_t target) {
    while (true) {
        pqxx::work work(connection);
        work.exec(kLock);
        const std::uint32_t version = version_of(work);
        if (version > kPostgresSteps.size()) {
            return StoreResult<bool>::failure(newer(version));
        }
        if (version >= target) {
            return true;
        }
        if (version == 0) {
            work.exec("CREATE TABLE zoned_schema (version INTEGER PRIMARY KEY)");
        }
        work.exec(kPostgresSteps[version]);
        work.exec("INSERT INTO zoned_schema VALUES (" + std::to_string(version + 1) + ")");
        work.commit();
    }
}

class PostgresStore final : public Store {
  public:
    explicit PostgresStore(std::string url) : url_(with_patience(std::move(url))) {}

    StoreResult<bool> open(bool migrates) {
        return guarded<bool>([&]() -> StoreResult<bool> {
            connect();
            const std::string encoding = one("SHOW server_encoding");
            if (encoding != "UTF8") {
                return StoreResult<bool>::failure({StoreFault::kOther,
                                                   "PostgreSQL: the encoding of the database is " +
                                                       encoding +
                                                       ": make one with ENCODING 'UTF8'"});
            }
            if (migrates) {
                auto done = migrate(*connection_, kPostgresSteps.size());
                if (!done.ok()) {
                    return done;
                }
            }
            std::uint32_t version = 0;
            {
                pqxx::read_transaction work(*connection_);
                version = version_of(work);
            }
            if (version > kPostgresSteps.size()) {
                return StoreResult<bool>::failure(newer(version));
            }
            if (version < kPostgresSteps.size()) {
                return StoreResult<bool>::failure(
                    {StoreFault::kOther,
                     "PostgreSQL: the schema of the database has version " +
                         std::to_string(version) +
                         "; start a server on it once, which brings it to version " +
                         std::to_string(kPostgresSteps.size())});
            }
            return true;
        });
    }

    StoreResult<bool> commit(std::span<const StoreChange> changes) override {
        return guarded<bool>([&]() -> StoreResult<bool> {
            connect();
            const std::size_t first = already_there(changes);
            if (first < changes.size()) {
                write(changes, first);
            }
            doubt_.reset();
            return true;
        });
    }

    StoreResult<std::optional<StoredBytes>> get(const StoreKey& key) override {
        return read<std::optional<StoredBytes>>([&](pqxx::transaction_base& work) {
            const pqxx::result rows = work.exec_prepared("get_record",
                                                         static_cast<int>(key.scope),
                                                         text(key.account),
                                                         text(key.character),
                                                         text(key.key));
            return rows.empty() ? std::nullopt : std::optional(bytes_of(rows[0][0]));
        });
    }

    StoreResult<std::vector<PutRecord>> records(const std::string& account) override {
        return read<std::vector<PutRecord>>([&](pqxx::transaction_base& work) {
            std::vector<PutRecord> out;
            for (const pqxx::row& row : work.exec_prepared("records", text(account))) {
                out.push_back({{static_cast<StoreScope>(row[0].as<int>()),
                                row[1].as<std::string>(),
                                row[2].as<std::string>(),
                                row[3].as<std::string>()},
                               bytes_of(row[4])});
            }
            return out;
        });
    }

    StoreResult<std::optional<StandingPlace>> stand(const std::string& account,
                                                    const std::string& character) override {
        using Out = std::optional<StandingPlace>;
        return read<Out>([&](pqxx::transaction_base& work) {
            const pqxx::result rows =
                work.exec_prepared("get_stand", text(account), text(character));
            return rows.empty() ? Out()
                                : Out(StandingPlace{{rows[0][0].as<double>(),
                                                     rows[0][1].as<double>(),
                                                     rows[0][2].as<double>()},
                                                    rows[0][3].as<std::string>()});
        });
    }

    StoreResult<std::vector<PutBan>> bans() override {
        return read<std::vector<PutBan>>([&](pqxx::transaction_base& work) {
            std::vector<PutBan> out;
            for (const pqxx::row& row : work.exec_prepared("bans")) {
                out.push_back({row[0].as<std::string>(),
                               row[1].as<std::int64_t>(),
                               row[2].as<std::string>()});
            }
            return out;
        });
    }

    StoreResult<std::vector<UseTicket>> tickets(std::int64_t unix_s) override {
        return read<std::vector<UseTicket>>([&](pqxx::transaction_base& work) {
            std::vector<UseTicket> out;
            for (const pqxx::row& row : work.exec_prepared("tickets", unix_s)) {
                UseTicket& ticket = out.emplace_back();
                const StoredBytes nonce = bytes_of(row[0]);
                std::copy_n(nonce.begin(),
                            std::min(nonce.size(), ticket.nonce.size()),
                            ticket.nonce.begin());
                ticket.expires_s = row[1].as<std::int64_t>();
            }
            return out;
        });
    }

    StoreResult<std::vector<StoredEvent>> events(const std::string& account,
                                                 std::size_t most) override {
        return read<std::vector<StoredEvent>>([&](pqxx::transaction_base& work) {
            const auto limit = static_cast<std::int64_t>(most);
            const pqxx::result rows = account.empty()
                                          ? work.exec_prepared("events", limit)
                                          : work.exec_prepared("events_of", text(account), limit);
            std::vector<StoredEvent> out;
            for (const pqxx::row& row : rows) {
                StoredEvent& event = out.emplace_back();
                event.number = row[0].as<std::int64_t>();
                event.unix_ms = row[1].as<std::int64_t>();
                event.tick = row[2].as<std::int64_t>();
                event.zone = static_cast<std::uint16_t>(row[3].as<int>());
                event.kind = static_cast<std::uint16_t>(row[4].as<int>());
                event.account = row[5].as<std::string>();
                event.topic = row[6].as<std::string>();
                event.payload = bytes_of(row[7]);
            }
            std::reverse(out.begin(), out.end());
            return out;
        });
    }

    StoreResult<StoreCounts> counts() override {
        return read<StoreCounts>([&](pqxx::transaction_base& work) {
            const auto count = [&](const char* table) {
                return work.exec1(std::string("SELECT count(*) FROM ") + table)[0]
                    .as<std::uint64_t>();
            };
            StoreCounts out;
            out.schema = version_of(work);
            out.accounts = count("account");
            out.characters = count("character");
            out.records = count("record");
            out.bans = count("ban");
            out.tickets = count("ticket");
            out.events = count("event");
            return out;
        });
    }

    StoreResult<std::vector<std::string>> check() override {
        return read<std::vector<std::string>>([&](pqxx::transaction_base& work) {
            // A damaged page makes the read fail.
            work.exec("SELECT sum(length(value)) FROM record");
            work.exec("SELECT sum(length(payload)) FROM event");
            for (const char* table : {"account", "character", "ban", "ticket"}) {
                work.exec(std::string("SELECT sum(length(t::text)) FROM ") + table + " t");
            }
            return std::vector<std::string>();
        });
    }

    StoreResult<bool> backup(const std::string&) override {
        return StoreResult<bool>::failure(
            {StoreFault::kOther,
             "PostgreSQL: its own tools back it up while servers run: pg_dump, pg_restore"});
    }

  private:
    /// A commit whose answer was lost: its changes may be there, and must not come twice.
    struct Doubt {
        std::vector<StoreChange> changes;
        std::size_t there = 0;         ///< so many of them, from the front, are known to be there
        std::int64_t transaction = 0;  ///< what became of this one decides on the rest; 0: known
    };

    void connect() {
        if (connection_ && connection_->is_open()) {
            return;
        }
        quiet_.reset();
        connection_ = nullptr;
        connection_ = std::make_unique<pqxx::connection>(url_);
        // Without this one, libpqxx prints what it meets to stderr.
        quiet_.emplace(*connection_);
        pqxx::nontransaction(*connection_).exec(kSession);
        connection_->prepare("status", "SELECT txid_status($1)");
        for (const auto& [name, sql] : kPrepared) {
            connection_->prepare(name, sql);
        }
    }

    std::string one(const char* sql) {
        pqxx::read_transaction work(*connection_);
        return work.exec1(sql)[0].as<std::string>();
    }

    /// How many of the changes an earlier call with them, or with the first of them, has stored.
    std::size_t already_there(std::span<const StoreChange> changes) {
        if (!doubt_) {
            return 0;
        }
        if (doubt_->transaction != 0) {
            if (was_committed(doubt_->transaction)) {
                doubt_->there = doubt_->changes.size();
            }
            doubt_->transaction = 0;
        }
        const auto there = std::span<const StoreChange>(doubt_->changes).first(doubt_->there);
        if (there.size() > changes.size() ||
            !std::equal(there.begin(), there.end(), changes.begin())) {
            doubt_.reset();
            return 0;
        }
        return there.size();
    }

    void write(std::span<const StoreChange> changes, std::size_t first) {
        pqxx::work work(*connection_);
        const auto transaction = work.exec1("SELECT txid_current()")[0].as<std::int64_t>();
        for (const StoreChange& change : changes.subspan(first)) {
            std::visit([&](const auto& c) { apply(work, c); }, change);
        }
        try {
            work.commit();
        } catch (...) {
            doubt_ = Doubt{{changes.begin(), changes.end()}, first, transaction};
            throw;
        }
    }

    bool was_committed(std::int64_t transaction) {
        std::string status;
        try {
            pqxx::read_transaction work(*connection_);
            const pqxx::row row = work.exec_prepared1("status", transaction);
            status = row[0].is_null() ? "" : row[0].as<std::string>();
        } catch (const pqxx::sql_error&) {
            // A database that was restored from before has never heard of it.
            return false;
        }
        if (status == "in progress") {
            throw StillUnderWay();
        }
        return status == "committed";
    }

    template <class T, class Read>
    StoreResult<T> read(Read read) {
        const auto attempt = [&] {
            return guarded<T>([&]() -> StoreResult<T> {
                connect();
                pqxx::read_transaction work(*connection_);
                return read(work);
            });
        };
        // A connection tells only when it is used that it was lost: a read can begin anew.
        const bool was_open = connection_ && connection_->is_open();
        StoreResult<T> out = attempt();
        return was_open && !out.ok() && out.error().fault == StoreFault::kLost ? attempt()
                                                                               : std::move(out);
    }

    static void apply(pqxx::work& work, const PutRecord& c) {
        work.exec_prepared("put_record",
                           static_cast<int>(c.key.scope),
                           text(c.key.account),
                           text(c.key.character),
                           text(c.key.key),
                           binary(c.value));
    }

    static void apply(pqxx::work& work, const RemoveRecord& c) {
        work.exec_prepared("remove_record",
                           static_cast<int>(c.key.scope),
                           text(c.key.account),
                           text(c.key.character),
                           text(c.key.key));
    }

    static void apply(pqxx::work& work, const ForgetRecords& c) {
        work.exec_prepared("forget_records", text(c.account));
    }

    static void apply(pqxx::work& work, const NoteLogin& c) {
        work.exec_prepared("note_account", text(c.account), c.unix_s);
        work.exec_prepared("note_character", text(c.account), text(c.character), c.unix_s);
    }

    static void apply(pqxx::work& work, const PutStand& c) {
        const std::array<double, 3>& at = c.place.position_m;
        work.exec_prepared("put_stand",
                           at[0],
                           at[1],
                           at[2],
                           text(c.place.world),
                           text(c.account),
                           text(c.character));
    }

    static void apply(pqxx::work& work, const PutBan& c) {
        work.exec_prepared("put_ban", text(c.account), c.until_unix_s, text(c.reason));
    }

    static void apply(pqxx::work& work, const RemoveBan& c) {
        work.exec_prepared("remove_ban", text(c.account));
    }

    static void apply(pqxx::work& work, const UseTicket& c) {
        work.exec_prepared("use_ticket", binary(c.nonce), c.expires_s);
    }

    static void apply(pqxx::work& work, const ForgetTickets& c) {
        work.exec_prepared("forget_tickets", c.expired_at_s);
    }

    static void apply(pqxx::work& work, const AddEvent& c) {
        work.exec_prepared("add_event",
                           c.unix_ms,
                           static_cast<std::int64_t>(c.tick),
                           static_cast<int>(c.zone),
                           static_cast<int>(c.kind),
                           text(c.account),
                           text(c.topic),
                           binary(c.payload));
    }

    std::string url_;
    std::unique_ptr<pqxx::connection> connection_;
    std::optional<pqxx::quiet_errorhandler> quiet_;  // goes before its connection
    std::optional<Doubt> doubt_;
};

}  // namespace

StoreResult<std::unique_ptr<Store>> open_postgres_store(const std::string& url, bool migrates) {
    auto store = std::make_unique<PostgresStore>(url);
    const auto done = store->open(migrates);
    if (!done.ok()) {
        return StoreResult<std::unique_ptr<Store>>::failure(done.error());
    }
    return StoreResult<std::unique_ptr<Store>>(std::move(store));
}

std::uint32_t postgres_schema() {
    return kPostgresSteps.size();
}

StoreResult<bool> migrate_postgres(const std::string& url, std::uint32_t target) {
    return guarded<bool>([&] {
        pqxx::connection connection(url);
        const pqxx::quiet_errorhandler quiet(connection);
        return migrate(connection, target);
    });
}

}  // namespace zoned::store
