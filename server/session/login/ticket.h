// Ticket: a permission to log in, signed with Ed25519 (RFC 8032) by the operator's login service.
#pragma once

#include "shared/core/result.h"

#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace zoned::session {

using PublicKey = std::array<std::uint8_t, 32>;
using PrivateKey = std::array<std::uint8_t, 32>;  ///< the seed of RFC 8032, section 5.1.5
using TicketNonce = std::array<std::uint8_t, 16>;

struct KeyPair {
    PublicKey public_key{};
    PrivateKey private_key{};
};

/// A new random key pair.
[[nodiscard]] KeyPair generate_key_pair();

/// The public key that belongs to a private one.
[[nodiscard]] PublicKey public_key_of(const PrivateKey& key);

/// The content of a ticket.
struct TicketClaims {
    std::string account;       ///< 1..64 bytes
    std::string name;          ///< shown to others, 1..32 bytes of UTF-8; empty: the client chooses
    std::string team;          ///< at most 32 bytes; empty: the client chooses
    std::uint32_t rights = 0;  ///< bits of mailbox::Right
    std::int64_t not_before_s = 0;  ///< Unix time
    std::int64_t expires_s = 0;     ///< Unix time
    TicketNonce nonce{};            ///< a ticket opens one session only
    std::string world = {};         ///< it opens no other; empty: any
};

/// A nonce for a new ticket.
[[nodiscard]] TicketNonce random_nonce();

/// Serialises and signs claims (proto Ticket). Fails when a claim is outside its range.
[[nodiscard]] core::Result<std::vector<std::uint8_t>> create_ticket(const TicketClaims& claims,
                                                                    const PrivateKey& key);

/// Checks form, signature (by any of `keys`) and time, in this order. `unix_s` is the present Unix
/// time. The error is one clear sentence. Whether the nonce was used before is the caller's
/// business.
[[nodiscard]] core::Result<TicketClaims> verify_ticket(std::span<const std::uint8_t> ticket,
                                                       std::span<const PublicKey> keys,
                                                       std::int64_t unix_s);

}  // namespace zoned::session
