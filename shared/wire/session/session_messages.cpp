#include "shared/wire/session/session_messages.h"

namespace zoned::wire {

std::string_view text_of(RefusedReason reason) {
    switch (reason) {
        case RefusedReason::kUnspecified:
            break;
        case RefusedReason::kProtocolVersion:
            return "client and server speak different versions of the protocol";
        case RefusedReason::kConfigDigest:
            return "the server runs another config";
        case RefusedReason::kTicket:
            return "the ticket is not valid";
        case RefusedReason::kServerFull:
            return "the server is full";
        case RefusedReason::kResume:
            return "the session is over: log in anew";
        case RefusedReason::kMalformed:
            return "the server could not read the login";
        case RefusedReason::kShuttingDown:
            return "the server is shutting down";
        case RefusedReason::kBanned:
            return "banned";
        case RefusedReason::kElsewhere:
            return "another server of the cluster has it";
    }
    return "for no reason that this client knows";
}

std::string_view text_of(ClosingReason reason) {
    switch (reason) {
        case ClosingReason::kUnspecified:
            break;
        case ClosingReason::kShutdown:
            return "it shuts down";
        case ClosingReason::kKicked:
            return "kicked";
        case ClosingReason::kTimeout:
            return "it heard nothing for too long";
        case ClosingReason::kReplaced:
            return "the session goes on over another connection";
        case ClosingReason::kProtocol:
            return "this client broke the protocol";
        case ClosingReason::kElsewhere:
            return "the character is in another world";
    }
    return "for no reason that this client knows";
}

template void encode_message(const ClientMessage&, std::vector<std::uint8_t>&);
template bool decode_message(std::span<const std::uint8_t>, ServerMessage&);
template bool decode_message(std::span<const std::uint8_t>, SharedEnvironmentMessage&);
template bool decode_message(std::span<const std::uint8_t>, ParticleBurstMessage&);

}  // namespace zoned::wire
