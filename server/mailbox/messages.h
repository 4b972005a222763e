// Messages between the network side and the zones: the only things that cross between their
// threads.
#pragma once

#include "server/mailbox/store_messages.h"
#include "shared/core/containers/inline_vector.h"
#include "shared/core/ids.h"
#include "shared/motion/input_command.h"
#include "shared/wire/packet.h"

#include <cstdint>
#include <memory>
#include <string>
#include <variant>
#include <vector>

namespace zoned::ai {
struct AiSettings;
}

namespace zoned::mailbox {

using Bytes = std::vector<std::uint8_t>;

/// The rights that a ticket gives.
enum Right : std::uint32_t {
    kRightPlay = 1u << 0,
    kRightAudit = 1u << 1,   ///< may receive the truth (a wall-hack otherwise)
    kRightFreeze = 1u << 2,  ///< may freeze the world, as the final comparison does
    kRightAdmin = 1u << 3,
};

enum class LeaveReason : std::uint8_t {
    kQuit,
    kTimeout,
    kKicked,
    kShutdown
};

// ---- network -> zones ----

/// A client logged in and wants an avatar. Routed to the zone that the world picks for spawning.
struct Join {
    ClientId client;
    std::string name;  ///< validated UTF-8, 1..32 bytes
    std::string team;  ///< topic "team/<team>"; may be empty
    std::uint32_t rights = kRightPlay;
    double spawn[3] = {0,
                       0,
                       0};  ///< world coordinates, m; filled in where the join is routed to a zone
    std::string account;    ///< of the ticket; empty: the client cannot be known again
    bool placed = false;    ///< `spawn` is where the character stood when it was here last
};

struct Leave {
    ClientId client;
    LeaveReason reason = LeaveReason::kQuit;
};

/// Commands of one input packet that passed the input gate, ascending by tick.
struct Input {
    ClientId client;
    core::InlineVector<motion::InputCommand, wire::kMaxCommandsPerPacket> commands;
};

/// Which state packets a client has: sequence numbers as in replication's Packet.
struct Acks {
    ClientId client;
    std::uint64_t newest = 0;
    std::uint32_t bits = 0;    ///< bit i: newest - 1 - i has arrived as well
    std::uint32_t rtt_us = 0;  ///< smoothed round trip as the session measures it
    std::uint32_t rate_bytes_per_s =
        0;  ///< the path's capacity as the session measures it, headers counted; 0: no limit known
    std::uint32_t rtt_variation_us = 0;  ///< mean deviation of the round trip
};

/// Whether packets to this client have anywhere to go: a stream, or an address from which it was
/// heard within the last second. Until one of these is back it is sent nothing at all. Its next
/// input or acknowledgement says the same as `on`.
struct Reach {
    ClientId client;
    bool on = true;
};

/// A reliable command to the rules of the game.
struct Command {
    ClientId client;
    std::uint16_t kind = 0;
    Bytes payload;
    std::uint64_t number = 0;  ///< of the session's commands: 1, 2, 3, ...
};

/// The client has carried out an event that asked for confirmation.
struct Confirm {
    ClientId client;
    EventId event;
};

/// A client detected that its view diverged beyond repair: everything is sent to it again,
/// absolute.
struct ViewReset {
    ClientId client;
};

/// Stops or resumes the simulation of all zones; replication goes on.
struct Freeze {
    bool on = true;
};

/// Asks for an audit record of this client at the next tick (also taken periodically when audits
/// are on).
struct AuditRequest {
    ClientId client;
};

/// The price of coding records for one client alone on this machine, as measured outside of the
/// step: CPU time of encoder and learning, ns. Sent to all zones. The initial value is that of the
/// benchmark's machine.
struct CodecPrice {
    std::uint32_t record_ns = 900;
    std::uint32_t packet_ns = 1000;
};

/// Agents by brains that were read anew, to all zones. Whether they fit the world was found
/// out before it was sent.
struct NewBrains {
    std::shared_ptr<const std::string> config;       ///< as recordings hold it
    std::shared_ptr<const ai::AiSettings> settings;  ///< the agents' settings in it, compiled
};

/// An operator wants an entity at a place.
struct SpawnOrder {
    std::uint64_t number = 0;  ///< of the answer
    TypeIndex type = 0;
    double position[3] = {0, 0, 0};  ///< world coordinates, m
    std::uint16_t yaw = 0;           ///< characters
};

/// An operator moves an entity, as rules teleport one.
struct MoveOrder {
    std::uint64_t number = 0;
    EntityId entity;
    double position[3] = {0, 0, 0};
};

/// A text of an operator to one client, or to all (none).
struct Notice {
    ClientId client;
    std::string text;
};

// Known again after a crash by these three, which the zones do not see.

/// A session began; its Join follows.
struct SessionBegun {
    ClientId client;
    Bytes token_digest;  ///< SHA-256 of the token by which its client comes back
    std::string account;
    std::string name;
    std::string team;
    std::uint32_t rights = kRightPlay;
    bool ticketed = false;  ///< the account is somebody's: it came with a ticket
};

/// How far a session has come.
struct SessionProgress {
    ClientId client;
    std::uint64_t commands = 0;  ///< numbers of commands used up, refused ones among them
    std::uint64_t events = 0;    ///< numbers of events that the client has
};

/// The requests of that tick are in the store, or it refused them.
struct StoreKept {
    Tick tick = 0;
};

using InboxItem = std::variant<Join,
                               Leave,
                               Input,
                               Acks,
                               Command,
                               Confirm,
                               ViewReset,
                               Freeze,
                               AuditRequest,
                               CodecPrice,
                               NewBrains,
                               SpawnOrder,
                               MoveOrder,
                               StoreAnswer,
                               Notice,
                               SessionBegun,
                               SessionProgress,
                               StoreKept,
                               Reach>;

// ---- zones -> network ----

/// A state packet for one client: body as in shared/wire/packet.h, sealed by the session layer
/// under `sequence`.
struct StatePacket {
    ClientId client;
    std::uint64_t sequence = 0;  ///< strictly ascending per client, across zones
    Bytes body;
};

/// A reliable event with its recipients already resolved, ascending by client id.
struct EventOut {
    EventId event;
    Tick tick = 0;
    std::uint16_t kind = 0;  ///< of the rules
    bool confirm = false;    ///< the client must answer with Confirm
    bool durable = false;    ///< leaves the server when the store has what its tick wrote
    bool history = false;    ///< of a topic, from before its recipient subscribed
    std::string topic;       ///< empty for direct events
    Bytes payload;
    std::vector<ClientId> recipients;
};

/// The client plays in this world now (first join) or its avatar changed.
struct Joined {
    ClientId client;
    EntityId avatar;
    ZoneId zone;
    Tick tick = 0;
};

/// The rules throw a client out.
struct Kick {
    ClientId client;
    std::string reason;
};

/// Truth of one entity at the audit's tick.
struct AuditEntity {
    EntityId entity;
    TypeIndex type = 0;
    double position[3] = {0, 0, 0};       ///< world coordinates, m
    float orientation[4] = {1, 0, 0, 0};  ///< w, x, y, z
    float distance_m = 0.0F;              ///< from the viewer's avatar
    float bound_m = 0.0F;                 ///< position bound promised at that distance
    float bound_rad = 0.0F;               ///< orientation bound
    bool must_know =
        false;  ///< within aura and nimbus now; else it lies in the hysteresis band: may be known
    Tick discontinuity_tick = 0;  ///< last spawn, teleport or unhide
    Tick radii_tick = 0;          ///< when its stance, and so its radii, last became others
    Tick breach_tick =
        0;  ///< when truth last left the prediction of its own last publication, 0 = never
    std::vector<std::int32_t>
        quantized;  ///< frozen worlds only: the exact integers of wire::QuantizedState
    std::vector<std::uint32_t> field_words;  ///< its declared fields as they are now ...
    std::vector<Tick> field_ticks;           ///< ... and when each of them changed last
};

/// The packets about one entity that a client has not acknowledged yet. The client may check them
/// against those that came. They state nothing about the truth.
struct AuditUpdate {
    EntityId entity;
    Tick postponed_tick = 0;  ///< when the byte budget last made something of it wait; 0 = never
    bool leaving = false;     ///< the packets carry its removal

    struct Carried {
        Tick tick = 0;
        std::uint64_t sequence = 0;
    };

    std::vector<Carried> carried;  ///< packets with updates of it, as they were sent
};

/// The knowledge that one client should have at `tick`, computed by brute force from raw state.
struct AuditRecord {
    ClientId client;
    Tick tick = 0;
    ZoneId zone;
    bool frozen = false;
    double avatar_position[3] = {0, 0, 0};
    Tick avatar_discontinuity_tick = 0;
    Tick avatar_radii_tick = 0;
    std::vector<AuditEntity> entities;
    std::vector<AuditUpdate> updates;   ///< ascending by entity; only where there is something
    Tick updates_since = 0;             ///< from which tick on `updates` names all packets; 0: none
    std::vector<double> shared_clocks;  ///< their values, by number
    std::vector<double> shared_variables;  ///< likewise
    std::vector<std::uint32_t> doors;      ///< that rules move, by number: 1 open, 0 shut
    std::vector<Tick> platforms;           ///< that rules move, by number: ticks along the way
};

/// What became of an operator's order.
struct OrderDone {
    std::uint64_t number = 0;
    EntityId entity;
    std::string refused;  ///< why not; empty: it was carried out
};

/// A session's commands up to this number are in the journal: no crash loses them.
struct CommandsKept {
    ClientId client;
    std::uint64_t through = 0;
};

using OutboxItem =
    std::variant<StatePacket, EventOut, Joined, Kick, AuditRecord, OrderDone, CommandsKept>;

}  // namespace zoned::mailbox
