#include "server/session/login/ticket.h"

#include "server/mailbox/messages.h"
#include "server/session/login/display_names.h"
#include "server/session/login/secrets.h"
#include "proto/session.pb.h"
#include "shared/core/utf8.h"

#include <openssl/evp.h>

#include <algorithm>
#include <memory>
#include <stdexcept>

namespace zoned::session {

namespace {

using Claims = core::Result<TicketClaims>;

constexpr std::size_t kSignatureBytes = 64;
constexpr std::size_t kMaxTicketBytes = 1024;
constexpr std::uint32_t kAllRights =
    mailbox::kRightPlay | mailbox::kRightAudit | mailbox::kRightFreeze | mailbox::kRightAdmin;

struct KeyFree {
    void operator()(EVP_PKEY* p) const { EVP_PKEY_free(p); }
};

struct ContextFree {
    void operator()(EVP_MD_CTX* p) const { EVP_MD_CTX_free(p); }
};

using Key = std::unique_ptr<EVP_PKEY, KeyFree>;
using Context = std::unique_ptr<EVP_MD_CTX, ContextFree>;

const std::uint8_t* bytes_of(const std::string& s) {
    return reinterpret_cast<const std::uint8_t*>(s.data());
}

Key load_private(const PrivateKey& key) {
    Key out(EVP_PKEY_new_raw_private_key(EVP_PKEY_ED25519, nullptr, key.data(), key.size()));
    if (!out) {
        throw std::runtime_error("Ed25519 is not available in this OpenSSL");
    }
    return out;
}

bool signature_fits(const proto::Ticket& ticket, const PublicKey& key) {
    const Key pkey(EVP_PKEY_new_raw_public_key(EVP_PKEY_ED25519, nullptr, key.data(), key.size()));
    const Context context(EVP_MD_CTX_new());
    return pkey && context &&
           EVP_DigestVerifyInit(context.get(), nullptr, nullptr, nullptr, pkey.get()) == 1 &&
           EVP_DigestVerify(context.get(),
                            bytes_of(ticket.signature()),
                            ticket.signature().size(),
                            bytes_of(ticket.claims()),
                            ticket.claims().size()) == 1;
}

/// The ranges that both the signing and the checking side insist on; empty text: in order.
std::string range_mistake(const TicketClaims& claims) {
    if (claims.account.empty() || claims.account.size() > 64 ||
        !core::is_clean_utf8(claims.account)) {
        return "the account must be 1 to 64 bytes of UTF-8 without control characters";
    }
    if (!claims.name.empty() && !is_valid_name(claims.name)) {
        return "the name must be 1 to 32 bytes of UTF-8 without control characters";
    }
    if (!is_valid_team(claims.team)) {
        return "the team must be at most 32 bytes of UTF-8 without control characters";
    }
    if (!claims.world.empty() && (claims.world.size() > 64 || !core::is_clean_utf8(claims.world))) {
        return "the world must be at most 64 bytes of UTF-8 without control characters";
    }
    if ((claims.rights & ~kAllRights) != 0) {
        return "the ticket names rights that do not exist";
    }
    if (claims.expires_s <= claims.not_before_s) {
        return "the ticket must expire after it begins";
    }
    return {};
}

core::Result<TicketClaims> parse_claims(const std::string& bytes) {
    proto::TicketClaims in;
    if (!in.ParseFromString(bytes)) {
        return Claims::failure("the ticket's claims cannot be read");
    }
    TicketClaims out;
    if (in.nonce().size() != out.nonce.size()) {
        return Claims::failure("the ticket's nonce must have 16 bytes");
    }
    std::copy_n(bytes_of(in.nonce()), out.nonce.size(), out.nonce.begin());
    out.account = in.account();
    out.name = in.name();
    out.team = in.team();
    out.rights = in.rights();
    out.not_before_s = in.not_before_s();
    out.expires_s = in.expires_s();
    out.world = in.world();
    if (std::string mistake = range_mistake(out); !mistake.empty()) {
        return Claims::failure(std::move(mistake));
    }
    return out;
}

}  // namespace

KeyPair generate_key_pair() {
    KeyPair pair;
    random_bytes(pair.private_key);
    pair.public_key = public_key_of(pair.private_key);
    return pair;
}

PublicKey public_key_of(const PrivateKey& key) {
    const Key pkey = load_private(key);
    PublicKey out{};
    std::size_t size = out.size();
    if (EVP_PKEY_get_raw_public_key(pkey.get(), out.data(), &size) != 1 || size != out.size()) {
        throw std::runtime_error("Ed25519 is not available in this OpenSSL");
    }
    return out;
}

TicketNonce random_nonce() {
    TicketNonce nonce{};
    random_bytes(nonce);
    return nonce;
}

core::Result<std::vector<std::uint8_t>> create_ticket(const TicketClaims& claims,
                                                      const PrivateKey& key) {
    using Out = core::Result<std::vector<std::uint8_t>>;
    if (std::string mistake = range_mistake(claims); !mistake.empty()) {
        return Out::failure(std::move(mistake));
    }
    proto::TicketClaims message;
    message.set_account(claims.account);
    message.set_name(claims.name);
    message.set_team(claims.team);
    message.set_rights(claims.rights);
    message.set_not_before_s(claims.not_before_s);
    message.set_expires_s(claims.expires_s);
    message.set_nonce(claims.nonce.data(), claims.nonce.size());
    message.set_world(claims.world);

    proto::Ticket ticket;
    ticket.set_claims(message.SerializeAsString());
    const Key pkey = load_private(key);
    const Context context(EVP_MD_CTX_new());
    std::array<std::uint8_t, kSignatureBytes> signature{};
    std::size_t size = signature.size();
    if (!context || EVP_DigestSignInit(context.get(), nullptr, nullptr, nullptr, pkey.get()) != 1 ||
        EVP_DigestSign(context.get(),
                       signature.data(),
                       &size,
                       bytes_of(ticket.claims()),
                       ticket.claims().size()) != 1) {
        return Out::failure("Ed25519 is not available in this OpenSSL");
    }
    ticket.set_signature(signature.data(), size);
    const std::string text = ticket.SerializeAsString();
    return std::vector<std::uint8_t>(text.begin(), text.end());
}

core::Result<TicketClaims> verify_ticket(std::span<const std::uint8_t> ticket,
                                         std::span<const PublicKey> keys,
                                         std::int64_t unix_s) {
    proto::Ticket message;
    if (ticket.size() > kMaxTicketBytes ||
        !message.ParseFromArray(ticket.data(), static_cast<int>(ticket.size())) ||
        message.signature().size() != kSignatureBytes) {
        return Claims::failure("the ticket cannot be read");
    }
    if (keys.empty()) {
        return Claims::failure(
            "this server trusts no ticket key; its operator must configure one (zoned keygen)");
    }
    // Nothing inside is looked at before the signature holds.
    if (std::none_of(keys.begin(), keys.end(), [&](const PublicKey& key) {
            return signature_fits(message, key);
        })) {
        return Claims::failure("the ticket's signature is by none of the keys this server trusts");
    }
    Claims claims = parse_claims(message.claims());
    if (!claims) {
        return claims;
    }
    if (unix_s < claims->not_before_s) {
        return Claims::failure("the ticket is valid from Unix time " +
                               std::to_string(claims->not_before_s) +
                               " on; the server's clock is " + std::to_string(unix_s));
    }
    if (unix_s >= claims->expires_s) {
        return Claims::failure("the ticket expired at Unix time " +
                               std::to_string(claims->expires_s) + "; the server's clock is " +
                               std::to_string(unix_s) + ": get a new one");
    }
    return claims;
}

}  // namespace zoned::session
