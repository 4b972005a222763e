// Store: the interface to what a server keeps on disk: accounts, characters, records of the rules,
// bans, used tickets, durable events.
#pragma once

#include "server/mailbox/store_messages.h"
#include "shared/core/ids.h"
#include "shared/core/result.h"

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <variant>
#include <vector>

namespace zoned::store {

using mailbox::StoreKey;
using mailbox::StoreScope;
using StoredBytes = std::vector<std::uint8_t>;

enum class StoreFault : std::uint8_t {
    kBusy,         ///< another process holds it: may pass
    kFull,         ///< no room on the disk: may pass
    kLost,         ///< no connection to the database: may pass
    kDamaged,      ///< the file is no database, or a broken one
    kNewerSchema,  ///< written by a newer server
    kOther,
};

/// Text for an operator: what happened, to which file, and what to do.
struct StoreError {
    StoreFault fault = StoreFault::kOther;
    std::string text;
};

template <class T>
using StoreResult = core::Result<T, StoreError>;

/// Where a character stood when it was last heard of.
struct StandingPlace {
    std::array<double, 3> position_m{};  ///< world coordinates
    std::string world;                   ///< digest of the config: another world has other ground

    bool operator==(const StandingPlace&) const = default;
};

// ---- changes

struct PutRecord {
    StoreKey key;
    StoredBytes value;

    bool operator==(const PutRecord&) const = default;
};

struct RemoveRecord {
    StoreKey key;

    bool operator==(const RemoveRecord&) const = default;
};

/// All records of an account and of its characters: what its new ones take the place of.
struct ForgetRecords {
    std::string account;

    bool operator==(const ForgetRecords&) const = default;
};

/// An account logs in with a character; both are made where they are new.
struct NoteLogin {
    std::string account;
    std::string character;
    std::int64_t unix_s = 0;

    bool operator==(const NoteLogin&) const = default;
};

struct PutStand {
    std::string account;
    std::string character;
    StandingPlace place;

    bool operator==(const PutStand&) const = default;
};

struct PutBan {
    std::string account;
    std::int64_t until_unix_s = 0;  ///< 0: for ever
    std::string reason;

    bool operator==(const PutBan&) const = default;
};

struct RemoveBan {
    std::string account;

    bool operator==(const RemoveBan&) const = default;
};

/// A ticket opens one session, also across restarts.
struct UseTicket {
    std::array<std::uint8_t, 16> nonce{};
    std::int64_t expires_s = 0;

    bool operator==(const UseTicket&) const = default;
};

/// Tickets that have expired need no memory.
struct ForgetTickets {
    std::int64_t expired_at_s = 0;

    bool operator==(const ForgetTickets&) const = default;
};

struct AddEvent {
    std::int64_t unix_ms = 0;
    Tick tick = 0;
    std::uint16_t zone = 0;
    std::uint16_t kind = 0;
    std::string account;  ///< whose event it is; empty: of a topic, or of those around
    std::string topic;
    StoredBytes payload;

    bool operator==(const AddEvent&) const = default;
};

using StoreChange = std::variant<PutRecord,
                                 RemoveRecord,
                                 ForgetRecords,
                                 NoteLogin,
                                 PutStand,
                                 PutBan,
                                 RemoveBan,
                                 UseTicket,
                                 ForgetTickets,
                                 AddEvent>;

/// Bytes that a change takes in memory and, about, on disk.
[[nodiscard]] std::size_t size_of(const StoreChange& change);

// ---- what is read

struct StoredEvent : AddEvent {
    std::int64_t number = 0;  ///< ascending in the order of the commits
};

struct StoreCounts {
    std::uint32_t schema = 0;
    std::uint64_t accounts = 0;
    std::uint64_t characters = 0;
    std::uint64_t records = 0;
    std::uint64_t bans = 0;
    std::uint64_t tickets = 0;
    std::uint64_t events = 0;
};

/// One connection, for one thread at a time. Nothing throws.
class Store {
  public:
    Store() = default;
    Store(const Store&) = delete;
    Store& operator=(const Store&) = delete;
    virtual ~Store() = default;

    /// All changes in their order, in one transaction; durable when it returns. On an error none of
    /// them is there, and the same call, or one with more changes behind these, may be made again.
    virtual StoreResult<bool> commit(std::span<const StoreChange> changes) = 0;

    virtual StoreResult<std::optional<StoredBytes>> get(const StoreKey& key) = 0;
    /// All records of an account and of its characters, by scope, character and key.
    virtual StoreResult<std::vector<PutRecord>> records(const std::string& account) = 0;
    virtual StoreResult<std::optional<StandingPlace>> stand(const std::string& account,
                                                            const std::string& character) = 0;
    virtual StoreResult<std::vector<PutBan>> bans() = 0;
    /// Tickets that had not expired by then.
    virtual StoreResult<std::vector<UseTicket>> tickets(std::int64_t unix_s) = 0;
    /// The newest `most` events, ascending; of this account, or of all (empty).
    virtual StoreResult<std::vector<StoredEvent>> events(const std::string& account,
                                                         std::size_t most) = 0;
    virtual StoreResult<StoreCounts> counts() = 0;

    /// Reads everything. The list of what is wrong, each a sentence; empty: it is whole.
    virtual StoreResult<std::vector<std::string>> check() = 0;
    /// A copy in one piece while others write. `file` must not be there.
    virtual StoreResult<bool> backup(const std::string& file) = 0;
};

}  // namespace zoned::store
