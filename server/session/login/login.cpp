#include "server/session/login/login.h"

#include "server/session/login/display_names.h"

#include <utility>

namespace zoned::session {

namespace {

using CheckedIdentity = core::Result<Identity, Refusal>;

core::Result<Identity, Refusal> refuse_ticket(std::string text) {
    return CheckedIdentity::failure({proto::REFUSED_TICKET, Reject::kLoginTicket, std::move(text)});
}

core::Result<Identity, Refusal> from_ticket(const HostSettings& settings,
                                            const proto::Hello& hello,
                                            std::int64_t unix_s,
                                            NonceSet& nonces) {
    const std::string& bytes = hello.ticket();
    core::Result<TicketClaims> claims =
        verify_ticket({reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size()},
                      settings.ticket_keys,
                      unix_s);
    if (!claims && !settings.cluster_keys.empty()) {
        // The cluster's own key opens nothing but the world that its tickets name.
        core::Result<TicketClaims> of_cluster =
            verify_ticket({reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size()},
                          settings.cluster_keys,
                          unix_s);
        if (of_cluster && of_cluster->world == settings.world_name) {
            claims = std::move(of_cluster);
        }
    }
    if (!claims) {
        return refuse_ticket(claims.error());
    }
    if (!claims->world.empty() && claims->world != settings.audience) {
        return refuse_ticket("the ticket is for the world " + claims->world + ", this server has " +
                             (settings.audience.empty() ? "another" : settings.audience));
    }
    if (nonces.contains(claims->nonce)) {
        return refuse_ticket("the ticket was used before: each opens one session, get a new one");
    }
    if (!nonces.has_room(unix_s)) {
        return refuse_ticket(
            "the server remembers as many used tickets as it can; try again "
            "when some have expired");
    }
    Identity id;
    id.account = claims->account;
    id.name = claims->name.empty() ? hello.name() : claims->name;
    id.team = claims->team.empty() ? hello.team() : claims->team;
    id.rights = claims->rights;
    id.nonce = claims->nonce;
    id.expires_s = claims->expires_s;
    return id;
}

}  // namespace

std::optional<Refusal> check_protocol(const HostSettings& settings, const proto::Hello& hello) {
    if (hello.protocol_version() != settings.protocol_version) {
        const bool client_older = hello.protocol_version() < settings.protocol_version;
        return Refusal{
            proto::REFUSED_PROTOCOL_VERSION,
            Reject::kLoginVersion,
            "the client speaks protocol version " + std::to_string(hello.protocol_version()) +
                ", the server speaks version " + std::to_string(settings.protocol_version) +
                ": update the " + (client_older ? "client" : "server")};
    }
    return std::nullopt;
}

std::optional<Refusal> check_versions(const HostSettings& settings, const proto::Hello& hello) {
    if (auto refusal = check_protocol(settings, hello)) {
        return refusal;
    }
    if (!hello.config_digest().empty() && hello.config_digest() != settings.config_digest) {
        return Refusal{proto::REFUSED_CONFIG_DIGEST,
                       Reject::kLoginDigest,
                       "the client's config has digest " + printable(hello.config_digest()) +
                           ", the server's has " + settings.config_digest +
                           ": give the client the server's config, or no digest"};
    }
    return std::nullopt;
}

core::Result<Identity, Refusal> check_identity(const HostSettings& settings,
                                               const proto::Hello& hello,
                                               bool loopback,
                                               std::int64_t unix_s,
                                               NonceSet& nonces) {
    CheckedIdentity identity = CheckedIdentity::failure({});
    if (!hello.ticket().empty()) {
        identity = from_ticket(settings, hello, unix_s, nonces);
    } else if (settings.dev_mode_loopback && loopback) {
        Identity id;
        id.account = "development";
        id.name = hello.name();
        id.team = hello.team();
        id.rights = settings.dev_rights;
        identity = id;
    } else if (settings.dev_mode_loopback) {
        return refuse_ticket(
            "the client sent no ticket; the server's development mode lets in "
            "only loopback addresses without one");
    } else {
        return refuse_ticket(
            "the client sent no ticket; the server lets nobody in without one "
            "(zoned ticket makes one)");
    }
    if (!identity) {
        return identity;
    }
    if (!is_valid_name(identity->name)) {
        return CheckedIdentity::failure(
            {proto::REFUSED_MALFORMED,
             Reject::kLoginMalformed,
             "the name must be 1 to 32 bytes of UTF-8 without control characters"});
    }
    if (!is_valid_team(identity->team)) {
        return CheckedIdentity::failure(
            {proto::REFUSED_MALFORMED,
             Reject::kLoginMalformed,
             "the team must be at most 32 bytes of UTF-8 without control characters"});
    }
    if ((identity->rights & mailbox::kRightPlay) == 0) {
        return refuse_ticket("the ticket does not give the right to play");
    }
    return identity;
}

}  // namespace zoned::session
