#include "server/session/login/nonce_set.h"

namespace zoned::session {

bool NonceSet::has_room(std::int64_t unix_s) {
    if (expiry_.size() >= capacity_) {
        forget_expired(unix_s);
    }
    return expiry_.size() < capacity_;
}

void NonceSet::prune(std::int64_t unix_s) {
    if (unix_s >= next_prune_s_) {
        next_prune_s_ = unix_s + 60;
        forget_expired(unix_s);
    }
}

void NonceSet::forget_expired(std::int64_t unix_s) {
    std::erase_if(expiry_, [&](const auto& entry) { return entry.second <= unix_s; });
}

}  // namespace zoned::session
