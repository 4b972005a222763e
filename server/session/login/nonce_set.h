// NonceSet: remembers used ticket nonces until they expire, so that a ticket opens one session.
#pragma once

#include "server/session/login/ticket.h"

#include <cstddef>
#include <cstdint>
#include <map>

namespace zoned::session {

/// Holds at most `capacity` unexpired nonces; when full it takes no more (the login is refused:
/// forgetting one would let a ticket be used twice).
class NonceSet {
  public:
    explicit NonceSet(std::size_t capacity) : capacity_(capacity) {}

    [[nodiscard]] bool contains(const TicketNonce& nonce) const {
        return expiry_.find(nonce) != expiry_.end();
    }

    /// True when another nonce can be remembered. Forgets expired ones first where that is needed.
    bool has_room(std::int64_t unix_s);

    /// Remembers a nonce until its ticket expires.
    void insert(const TicketNonce& nonce, std::int64_t expires_s) { expiry_[nonce] = expires_s; }

    /// Forgets a nonce that opened no session after all.
    void erase(const TicketNonce& nonce) { expiry_.erase(nonce); }

    /// Forgets expired nonces; cheap when called often (it looks once a minute).
    void prune(std::int64_t unix_s);

    [[nodiscard]] std::size_t size() const { return expiry_.size(); }

  private:
    void forget_expired(std::int64_t unix_s);

    std::size_t capacity_;
    std::int64_t next_prune_s_ = 0;
    std::map<TicketNonce, std::int64_t> expiry_;
};

}  // namespace zoned::session
