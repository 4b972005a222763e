// BanList: accounts that may not log in, each until a time or for ever.
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

namespace zoned::session {

struct AccountBan {
    std::string account;
    std::int64_t until_unix_s = 0;  ///< 0: for ever
    std::string reason;             ///< told to the client
};

/// Holds bans in memory; the caller keeps them on disk.
class BanList {
  public:
    /// Replaces what is known of the account.
    void ban(AccountBan ban) { bans_[ban.account] = std::move(ban); }

    /// False when the account was not banned.
    bool unban(const std::string& account) { return bans_.erase(account) != 0; }

    /// The ban that holds at this time, or null. One that is over is forgotten.
    const AccountBan* find(const std::string& account, std::int64_t unix_s) {
        const auto it = bans_.find(account);
        if (it == bans_.end()) {
            return nullptr;
        }
        if (it->second.until_unix_s != 0 && it->second.until_unix_s <= unix_s) {
            bans_.erase(it);
            return nullptr;
        }
        return &it->second;
    }

    /// Ascending by account.
    [[nodiscard]] std::vector<AccountBan> all() const {
        std::vector<AccountBan> out;
        for (const auto& [account, ban] : bans_) {
            out.push_back(ban);
        }
        return out;
    }

  private:
    std::map<std::string, AccountBan> bans_;
};

}  // namespace zoned::session
