// SessionMessages: the messages of the TCP session as plain structs: login, events, commands and
// audits. proto/session.proto says what each field means.
#pragma once

#include "shared/wire/session/world_messages.h"

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

namespace zoned::wire {

// ---------------------------------------------------------------- client to server

struct HelloMessage {
    std::uint32_t protocol_version = 0;
    std::string config_digest;
    std::string ticket;
    std::string name;
    std::string team;
    std::string resume_token;
    std::uint64_t last_event = 0;
    std::uint64_t last_command = 0;
    std::string world;

    static void fields(auto& m, auto& visit) {
        visit(1, m.protocol_version);
        visit(2, m.config_digest);
        visit(3, m.ticket);
        visit(4, m.name);
        visit(5, m.team);
        visit(6, m.resume_token);
        visit(7, m.last_event);
        visit(8, m.last_command);
        visit(20, m.world);
    }
};

struct CommandMessage {
    std::uint64_t number = 0;
    std::uint32_t kind = 0;
    std::string payload;

    static void fields(auto& m, auto& visit) {
        visit(1, m.number);
        visit(2, m.kind);
        visit(3, m.payload);
    }
};

struct EventAckMessage {
    std::uint64_t through = 0;

    static void fields(auto& m, auto& visit) { visit(1, m.through); }
};

struct ConfirmMessage {
    std::uint64_t event_id = 0;

    static void fields(auto& m, auto& visit) { visit(1, m.event_id); }
};

struct ViewResetMessage {
    std::string reason;

    static void fields(auto& m, auto& visit) { visit(1, m.reason); }
};

struct FreezeRequestMessage {
    bool on = false;

    static void fields(auto& m, auto& visit) { visit(1, m.on); }
};

struct AuditRequestMessage {
    static void fields(auto& /*m*/, auto& /*visit*/) {}
};

struct QuitMessage {
    static void fields(auto& /*m*/, auto& /*visit*/) {}
};

struct DatagramMessage {
    std::string sealed;

    static void fields(auto& m, auto& visit) { visit(1, m.sealed); }
};

struct ClientMessage {
    std::variant<std::monostate,
                 HelloMessage,
                 CommandMessage,
                 EventAckMessage,
                 ConfirmMessage,
                 ViewResetMessage,
                 FreezeRequestMessage,
                 AuditRequestMessage,
                 QuitMessage,
                 DatagramMessage>
        message;

    static void fields(auto& m, auto& visit) { visit.one_of(m.message); }
};

// ---------------------------------------------------------------- server to client

enum class RefusedReason : std::int32_t {
    kUnspecified = 0,
    kProtocolVersion = 1,
    kConfigDigest = 2,
    kTicket = 3,
    kServerFull = 4,
    kResume = 5,
    kMalformed = 6,
    kShuttingDown = 7,
    kBanned = 8,
    kElsewhere = 20,
};

/// For players, where the server says no more.
[[nodiscard]] std::string_view text_of(RefusedReason reason);

struct RedirectMessage {
    std::string world;
    std::string host;
    std::uint32_t tcp_port = 0;
    std::string ticket;
    std::string certificate_sha256;

    static void fields(auto& m, auto& visit) {
        visit(1, m.world);
        visit(2, m.host);
        visit(3, m.tcp_port);
        visit(4, m.ticket);
        visit(5, m.certificate_sha256);
    }
};

struct RefusedMessage {
    RefusedReason reason = RefusedReason::kUnspecified;
    std::string text;
    std::uint32_t protocol_version = 0;
    std::string config_digest;
    std::optional<RedirectMessage> redirect;

    static void fields(auto& m, auto& visit) {
        visit(1, m.reason);
        visit(2, m.text);
        visit(3, m.protocol_version);
        visit(4, m.config_digest);
        visit(20, m.redirect);
    }
};

struct WelcomeMessage {
    std::uint32_t client_id = 0;
    std::uint32_t connection_id = 0;
    std::uint32_t udp_port = 0;
    std::string resume_token;
    std::uint32_t grace_s = 0;
    bool resumed = false;
    std::uint64_t last_command = 0;
    std::string config_digest;
    std::optional<WorldDescriptionMessage> world;
    std::uint32_t rights = 0;
    bool recovered = false;
    std::string world_name;
    std::string datagram_key_down;
    std::string datagram_key_up;

    static void fields(auto& m, auto& visit) {
        visit(1, m.client_id);
        visit(2, m.connection_id);
        visit(3, m.udp_port);
        visit(4, m.resume_token);
        visit(5, m.grace_s);
        visit(6, m.resumed);
        visit(7, m.last_command);
        visit(8, m.config_digest);
        visit(9, m.world);
        visit(10, m.rights);
        visit(11, m.recovered);
        visit(20, m.world_name);
        visit(21, m.datagram_key_down);
        visit(22, m.datagram_key_up);
    }
};

struct EventMessage {
    std::uint64_t number = 0;
    std::uint64_t event_id = 0;
    std::int64_t tick = 0;
    std::uint32_t kind = 0;
    std::string topic;
    std::string payload;
    bool confirm = false;
    bool history = false;

    static void fields(auto& m, auto& visit) {
        visit(1, m.number);
        visit(2, m.event_id);
        visit(3, m.tick);
        visit(4, m.kind);
        visit(5, m.topic);
        visit(6, m.payload);
        visit(7, m.confirm);
        visit(8, m.history);
    }
};

struct JoinedMessage {
    std::uint32_t avatar = 0;
    std::uint32_t zone = 0;
    std::int64_t tick = 0;

    static void fields(auto& m, auto& visit) {
        visit(1, m.avatar);
        visit(2, m.zone);
        visit(3, m.tick);
    }
};

struct CommandAckMessage {
    std::uint64_t through = 0;

    static void fields(auto& m, auto& visit) { visit(1, m.through); }
};

struct AuditEntityMessage {
    std::uint32_t entity = 0;
    std::uint32_t type = 0;
    std::vector<double> position;
    std::vector<float> orientation;
    float distance_m = 0.0F;
    float bound_m = 0.0F;
    float bound_rad = 0.0F;
    bool must_know = false;
    std::int64_t discontinuity_tick = 0;
    std::int64_t breach_tick = 0;
    std::vector<std::int32_t> quantized;
    std::int64_t radii_tick = 0;
    std::vector<std::uint32_t> field_words;
    std::vector<std::int64_t> field_ticks;

    static void fields(auto& m, auto& visit) {
        visit(1, m.entity);
        visit(2, m.type);
        visit(3, m.position);
        visit(4, m.orientation);
        visit(5, m.distance_m);
        visit(6, m.bound_m);
        visit(7, m.bound_rad);
        visit(8, m.must_know);
        visit(9, m.discontinuity_tick);
        visit(10, m.breach_tick);
        visit(11, zigzag(m.quantized));
        visit(85, m.radii_tick);
        visit(86, m.field_words);
        visit(87, m.field_ticks);
    }
};

struct AuditUpdateMessage {
    std::uint32_t entity = 0;
    std::int64_t postponed_tick = 0;
    std::vector<std::int64_t> ticks;
    std::vector<std::uint64_t> sequences;
    bool leaving = false;

    static void fields(auto& m, auto& visit) {
        visit(1, m.entity);
        visit(2, m.postponed_tick);
        visit(3, m.ticks);
        visit(4, m.sequences);
        visit(5, m.leaving);
    }
};

struct AuditRecordMessage {
    std::int64_t tick = 0;
    std::uint32_t zone = 0;
    bool frozen = false;
    std::vector<double> avatar_position;
    std::int64_t avatar_discontinuity_tick = 0;
    std::vector<AuditEntityMessage> entities;
    std::vector<double> shared_clocks;
    std::vector<double> shared_variables;
    std::vector<std::uint32_t> doors;
    std::vector<std::int64_t> platforms;
    std::vector<AuditUpdateMessage> updates;
    std::int64_t avatar_radii_tick = 0;
    std::int64_t updates_since = 0;

    static void fields(auto& m, auto& visit) {
        visit(1, m.tick);
        visit(2, m.zone);
        visit(3, m.frozen);
        visit(4, m.avatar_position);
        visit(5, m.avatar_discontinuity_tick);
        visit(6, m.entities);
        visit(60, m.shared_clocks);
        visit(61, m.shared_variables);
        visit(62, m.doors);
        visit(63, m.platforms);
        visit(85, m.updates);
        visit(86, m.avatar_radii_tick);
        visit(87, m.updates_since);
    }
};

enum class ClosingReason : std::int32_t {
    kUnspecified = 0,
    kShutdown = 1,
    kKicked = 2,
    kTimeout = 3,
    kReplaced = 4,
    kProtocol = 5,
    kElsewhere = 20,
};

/// For players, where the server says no more.
[[nodiscard]] std::string_view text_of(ClosingReason reason);

struct ClosingMessage {
    ClosingReason reason = ClosingReason::kUnspecified;
    std::string text;
    std::optional<RedirectMessage> redirect;

    static void fields(auto& m, auto& visit) {
        visit(1, m.reason);
        visit(2, m.text);
        visit(20, m.redirect);
    }
};

struct ServerMessage {
    std::variant<std::monostate,
                 WelcomeMessage,
                 RefusedMessage,
                 EventMessage,
                 JoinedMessage,
                 AuditRecordMessage,
                 ClosingMessage,
                 DatagramMessage,
                 CommandAckMessage,
                 RedirectMessage>
        message;

    static void fields(auto& m, auto& visit) { visit.one_of(m.message); }
};

// The codec of all that travels by itself, compiled once in session_messages.cpp.
extern template void encode_message(const ClientMessage&, std::vector<std::uint8_t>&);
extern template bool decode_message(std::span<const std::uint8_t>, ServerMessage&);
extern template bool decode_message(std::span<const std::uint8_t>, SharedEnvironmentMessage&);
extern template bool decode_message(std::span<const std::uint8_t>, ParticleBurstMessage&);

}  // namespace zoned::wire
