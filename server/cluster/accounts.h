// Accounts: which world of the realm an account is in. It changes hands by one compare-and-set.
#pragma once

#include "server/cluster/board.h"
#include "server/cluster/settled_write.h"
#include "proto/cluster.pb.h"

#include <cstdint>
#include <string>
#include <vector>

namespace zoned::cluster {

/// The answer of the board when a player logs in.
struct AccountClaim {
    enum class Owner : std::uint8_t {
        kHere,      ///< the account is this world's, under `revision`
        kArriving,  ///< it is, and `entry` holds its records, which the store has to take first
        kElsewhere,
        kAgain,  ///< the board does not answer, or two servers ask at a time
    };

    Owner owner = Owner::kAgain;
    std::uint64_t revision = 0;
    proto::cluster::AccountEntry entry;
    std::string trouble;  ///< of kAgain
};

/// The entry of an account names its owner. Each call makes one attempt and waits for the board.
class Accounts {
  public:
    Accounts(Board& board, std::string world) : board_(board), world_(std::move(world)) {}

    /// For a login, or for an account that is said to be on its way. `epoch` is that of this
    /// server's claim to its world: what a server wants to write that had the world before it comes
    /// too late then. A login takes the arrival out of the entry; the caller hears of it this once.
    AccountClaim claim(const std::string& account, std::uint64_t epoch, bool login);

    /// The write that says: the records of `claim` are in the store.
    [[nodiscard]] SettledWrite accept(const AccountClaim& claim,
                                      std::uint64_t epoch,
                                      bool login) const;

    /// The write that gives an account to another world.
    [[nodiscard]] SettledWrite give(const proto::cluster::AccountEntry& entry,
                                    std::uint64_t revision,
                                    std::uint64_t epoch,
                                    const std::string& to,
                                    const std::string& arrival,
                                    std::vector<proto::cluster::Record> records) const;

    /// Letters and digits, whatever an account is called.
    [[nodiscard]] static std::string key_of(const std::string& account);

  private:
    Board& board_;
    std::string world_;
};

}  // namespace zoned::cluster
