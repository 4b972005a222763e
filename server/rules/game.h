// Game: the state of the sandbox game in one zone, and the small helpers that its features share.
#pragma once

#include "server/rules/records.h"
#include "server/rules/sandbox_settings.h"
#include "server/rules/touched_records.h"
#include "server/zone/rules.h"
#include "proto/sandbox.pb.h"

#include <cstdint>
#include <map>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <string_view>

namespace zoned::rules {

using zone::RulesContext;
using Payload = std::span<const std::uint8_t>;

/// Counted since the zone began; no part of the state.
struct GameStats {
    std::uint64_t commands = 0;
    std::uint64_t denied = 0;         ///< commands that were not carried out
    std::uint64_t malformed = 0;      ///< of these: payloads that could not be read or used
    std::uint64_t denials_muted = 0;  ///< of these: not even answered, the client asked too often
    std::uint64_t stray_confirms = 0;
    std::uint64_t bad_messages = 0;     ///< from other zones, unreadable
    std::uint64_t missed_messages = 0;  ///< whose target was not as they expected
    std::uint64_t bad_states = 0;       ///< load_entity could not read
    std::uint64_t shots = 0;
    std::uint64_t shots_as_seen = 0;  ///< of these: at the world as the shooter's client saw it
    std::uint64_t shots_cut = 0;      ///< of these: it asked for more than is rewound
    std::uint64_t shots_doubted = 0;  ///< of these: nothing explains the client's claim
    std::uint64_t hits = 0;
    std::uint64_t kills = 0;
    std::uint64_t kills_unconfirmed = 0;  ///< of these: announced after the time-out
    std::uint64_t respawns = 0;
    std::uint64_t trades = 0;
    std::uint64_t confirmed = 0;  ///< kills and trades, by each client concerned
    std::uint64_t ledgers_agreed = 0;
    std::uint64_t ledgers_repeated = 0;  ///< sent again: no word from the client yet
    std::uint64_t ledgers_diverged = 0;  ///< the client held something else
    std::uint64_t ledgers_given_up = 0;
    std::uint64_t chats = 0;
    std::uint64_t pick_ups = 0;
    std::uint64_t pick_ups_returned = 0;  ///< reserved for a picker who never took it
    std::uint64_t throws = 0;
    std::uint64_t pushes = 0;
    std::uint64_t rides = 0;
};

/// Ordered containers: their order enters hashes and results.
struct Game {
    GameSettings settings;
    TouchedRecords<CharacterRecord> characters;
    std::map<EntityId, PropRecord> props;        ///< only those with something to remember
    std::map<EntityId, RagdollRecord> ragdolls;  ///< by their roots
    std::map<ClientId, EntityId> avatars;
    std::set<EntityId> pending;  ///< entities with a running timer
    bool surveyed = false;       ///< the characters of the world's beginning have records
    GameStats stats;
};

/// The player behind a command, looked up once.
struct Actor {
    ClientId client;
    EntityId avatar;
    world::Row row = world::kNoRow;
    CharacterRecord* record = nullptr;
    std::uint16_t kind = 0;  ///< of the command
};

/// Row of an entity that this zone owns, or kNoRow.
world::Row owned_row(const RulesContext& context, EntityId entity);
bool is_character(const RulesContext& context, world::Row row);

/// Seconds as ticks, rounded up, >= 1.
Tick ticks(const RulesContext& context, float seconds);
Vec3d to_world(const RulesContext& context, const Vec3& local);
Vec3 to_local(const RulesContext& context, const Vec3d& world);
/// Where a character looks and throws from: half a radius above the centre of its head's sphere.
Vec3 eye(const RulesContext& context, world::Row row);
/// Unit vector from a client's numbers; none when they are not finite or all but zero.
std::optional<Vec3> direction(float x, float y, float z);

/// The record of a character that this zone owns, made when there is none yet.
CharacterRecord& record_of(Game& game, const RulesContext& context, world::Row row);
/// Notes whether the entity has a timer to run; call it after each change of a record's timers.
void update_pending(Game& game, EntityId entity);
/// Forgets all that is known of an entity.
void forget(Game& game, EntityId entity);

/// Event with a message of proto/sandbox.proto as its payload.
zone::RulesEvent event(sandbox::EventKind kind,
                       const google::protobuf::MessageLite& message,
                       bool confirm = false);
/// Answers a command that is not carried out; counted, and answered at most 10 times a second.
void deny(Game& game, RulesContext& context, const Actor& actor, const std::string& reason);
/// The same for a payload that cannot be read or used.
void deny_malformed(Game& game, RulesContext& context, const Actor& actor);

/// Generic cell rate algorithm (ITU-T I.371, annex A) in whole ticks: lets `burst` through at once
/// and then one per `interval`; `due` is the theoretical arrival time.
bool within_rate(Tick& due, Tick now, Tick interval, Tick burst);

/// Debris flies off a surface at `point` along its outward `normal`, where the world has such a
/// system. Cosmetic: clients are notified. Simulated: nobody is.
void throw_debris(const Game& game, RulesContext& context, const Vec3& point, const Vec3& normal);

}  // namespace zoned::rules
