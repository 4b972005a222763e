#include "server/cluster/accounts.h"

#include "shared/core/hex.h"

#include <utility>

namespace zoned::cluster {

using proto::cluster::AccountEntry;

namespace {

AccountClaim again(std::string trouble) {
    AccountClaim out;
    out.trouble = std::move(trouble);
    return out;
}

}  // namespace

std::string Accounts::key_of(const std::string& account) {
    return "account." +
           core::to_hex({reinterpret_cast<const std::uint8_t*>(account.data()), account.size()});
}

AccountClaim Accounts::claim(const std::string& account, std::uint64_t epoch, bool login) {
    const std::string key = key_of(account);
    const auto found = board_.get(key);
    if (!found.ok()) {
        return again(found.error().text);
    }
    AccountClaim out;
    if (*found) {
        out.revision = (*found)->revision;
        if (!out.entry.ParseFromString((*found)->value)) {
            return again(key + " cannot be read: a newer server may have written it");
        }
        if (out.entry.world() != world_) {
            out.owner = AccountClaim::Owner::kElsewhere;
            return out;
        }
        if (out.entry.state() == proto::cluster::ACCOUNT_ON_ITS_WAY) {
            out.owner = AccountClaim::Owner::kArriving;
            return out;
        }
        if (!login) {
            out.owner = AccountClaim::Owner::kHere;
            return out;
        }
    }
    // A board of several servers may answer with what was. It takes no write on top of that: so
    // each login writes, be there nothing new to say.
    AccountEntry mine = out.entry;
    mine.set_account(account);
    mine.set_world(world_);
    mine.set_epoch(epoch);
    mine.clear_arrival();
    SettledWrite write{key, out.revision, mine.SerializeAsString()};
    switch (write.attempt(board_)) {
        case SettledWrite::Outcome::kDone:
            out.revision = write.revision;
            out.owner = AccountClaim::Owner::kHere;
            // The caller hears of the arrival for the last time.
            out.entry.set_account(account);
            out.entry.set_world(world_);
            out.entry.set_epoch(epoch);
            return out;
        case SettledWrite::Outcome::kAgain:
            return again(write.trouble);
        case SettledWrite::Outcome::kOvertaken:
            break;
    }
    return again("another server writes " + key + " at the same time");
}

SettledWrite Accounts::accept(const AccountClaim& claim, std::uint64_t epoch, bool login) const {
    AccountEntry mine = claim.entry;
    mine.set_state(proto::cluster::ACCOUNT_HERE);
    mine.set_epoch(epoch);
    mine.clear_records();
    if (login) {
        mine.clear_arrival();
    }
    return {key_of(mine.account()), claim.revision, mine.SerializeAsString()};
}

SettledWrite Accounts::give(const AccountEntry& entry,
                            std::uint64_t revision,
                            std::uint64_t epoch,
                            const std::string& to,
                            const std::string& arrival,
                            std::vector<proto::cluster::Record> records) const {
    AccountEntry gone = entry;
    gone.set_world(to);
    gone.set_from_world(world_);
    gone.set_state(proto::cluster::ACCOUNT_ON_ITS_WAY);
    gone.set_epoch(epoch);
    gone.set_hops(entry.hops() + 1);
    gone.set_arrival(arrival);
    gone.clear_records();
    for (proto::cluster::Record& record : records) {
        *gone.add_records() = std::move(record);
    }
    return {key_of(entry.account()), revision, gone.SerializeAsString()};
}

}  // namespace zoned::cluster
