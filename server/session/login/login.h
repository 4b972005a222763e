// Login: the checks of Hello that need no session, each with a text for the user.
#pragma once

#include "server/session/login/nonce_set.h"
#include "server/session/login/ticket.h"
#include "server/session/reject.h"
#include "server/session/session_settings.h"
#include "proto/session.pb.h"
#include "shared/core/result.h"

#include <cstdint>
#include <optional>
#include <string>

namespace zoned::session {

/// Why a client is not let in: for the client (reason, text) and for the counters.
struct Refusal {
    proto::RefusedReason reason = proto::REFUSED_UNSPECIFIED;
    Reject counter = Reject::kLoginMalformed;
    std::string text;
};

/// The identity of a client, once its Hello has been believed.
struct Identity {
    std::string account;
    std::string name;
    std::string team;
    std::uint32_t rights = 0;
    /// Of the ticket, to be remembered once the session exists; none in development mode.
    std::optional<TicketNonce> nonce;
    std::int64_t expires_s = 0;
};

/// The protocol version alone: whatever else Hello holds has no meaning in another one.
[[nodiscard]] std::optional<Refusal> check_protocol(const HostSettings& settings,
                                                    const proto::Hello& hello);

/// Protocol version and config digest; nothing when both fit. The text names both sides.
[[nodiscard]] std::optional<Refusal> check_versions(const HostSettings& settings,
                                                    const proto::Hello& hello);

/// Ticket, or development mode on loopback. `nonces` is only asked, not changed, but for expired
/// entries.
[[nodiscard]] core::Result<Identity, Refusal> check_identity(const HostSettings& settings,
                                                             const proto::Hello& hello,
                                                             bool loopback,
                                                             std::int64_t unix_s,
                                                             NonceSet& nonces);

}  // namespace zoned::session
